"""Sentences of templates as plain text, and where templates are looked for."""
