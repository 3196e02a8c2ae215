"""Sentences of templates as plain text, and where templates are looked for.

Importing it imports Jinja, so that it is imported by the functions that word something.
"""

from vireport.wording import templates
from vireport.wording.templates import TEMPLATES, Words, environment_of, mistakes_named

__all__ = [
    "TEMPLATES",
    "Words",
    "environment_of",
    "mistakes_named",
    "templates",
]
