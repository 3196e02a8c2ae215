"""Scenarios, variants and earlier results side by side, in one table."""
