"""Charts: the loci of events in the plane of two inputs, the points where they meet, and their figure and files."""
