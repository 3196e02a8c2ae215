"""Numbers as text, tables of them, text in Markdown, text that is not ours, and the words of alerts."""
