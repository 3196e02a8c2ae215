"""The rigid-impact model simulated from event to event; knows nothing of the analytic solution."""
