"""Whether every device within the tolerances works, and how many do: proved in affine arithmetic, and sampled."""
