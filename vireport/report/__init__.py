"""The report of a study in HTML and PDF, and in the formats of CI systems."""

from vireport.report import context
from vireport.report.build import build_report
from vireport.report.certificates import certify_text
from vireport.report.ci_formats import github, junit, markdown
from vireport.report.pages import Block, Paragraph, ReportModel, section
from vireport.report.rendering import render_html, render_pdf

__all__ = [
    "Block",
    "Paragraph",
    "ReportModel",
    "build_report",
    "certify_text",
    "context",
    "github",
    "junit",
    "markdown",
    "render_html",
    "render_pdf",
    "section",
]
