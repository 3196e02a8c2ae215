"""Error against run time and extreme cases, as `vireport verify` prints them: each answer is right, or says why not."""
