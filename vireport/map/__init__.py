"""Stability over two inputs or more: exact curves of events, or cells on any number of cores."""
