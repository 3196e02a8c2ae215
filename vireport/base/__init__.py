"""What every room stands on: ways to fail, Ctrl-C, streams, files read and written, records, JSON, the version."""
