"""Every figure of a study, drawn from its numbers, with caption and alternative text."""
