"""What other starts come to: moments and ramps of switching on, windows, shocks, coexisting motions, jitter, basins."""
