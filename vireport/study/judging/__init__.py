"""Judging a study: requirements, alerts and the verdict."""
