"""The report of a study in HTML and PDF, and in the formats of CI systems."""
