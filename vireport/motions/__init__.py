"""Periodic motions of any word: what they are, what happens to them, and those with two impacts in closed form."""
