"""The design point: its motions and their margins, and how strongly they depend on each input."""
