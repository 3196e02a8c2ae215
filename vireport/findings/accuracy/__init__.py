"""Error against run time: every method on the motion and the critical point of a scenario, against 40 digits."""
