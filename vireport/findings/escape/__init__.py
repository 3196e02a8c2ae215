"""Escape: how long a motion lasts under random kicks."""
