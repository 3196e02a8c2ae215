"""The design point: its motions and their margins, and how strongly they hang on each input."""
