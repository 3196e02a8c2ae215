"""The device driven by a recorded motion of the shaker, compared with the periodic motion that is predicted."""
