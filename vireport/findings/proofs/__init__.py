"""Proofs of what comes to a stable motion: a region around it, the ball from rest, shocks up to a bound."""
