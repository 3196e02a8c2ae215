"""The design point: its motions, their margins, tolerances and yield, and how strongly they hang on each input."""
