"""Additions to a study, a folder each, beside one another: what else can be found out about a device."""
