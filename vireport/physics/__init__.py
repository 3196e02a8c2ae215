"""What analysis and simulation share: the device and its units, flight and impact law, membranes, kinds of numbers."""
