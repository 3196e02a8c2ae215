"""The report of a study in HTML and PDF, and in the formats of CI systems."""

from vireport.report.certificates import certify_text
from vireport.report.ci_formats import github, junit
from vireport.report.context import Report
from vireport.report.rendering import render_files, render_html, render_markdown, render_pdf

__all__ = [
    "Report",
    "certify_text",
    "github",
    "junit",
    "render_files",
    "render_html",
    "render_markdown",
    "render_pdf",
]
