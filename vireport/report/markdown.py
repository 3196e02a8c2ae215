"""A page in HTML as Markdown, as sites such as GitHub read it."""

from __future__ import annotations

import re

from bs4 import BeautifulSoup, Tag
from markdownify import ATX, MarkdownConverter

from vireport.text import markdown_text

_EDGES = re.compile(r"(^\s+|\s+$)")
_OPENING = re.compile(r"^(\d*)([-+#.)]+)(?=\s|$)")
"""What would begin a list or a heading at the start of a line."""


class _Converter(MarkdownConverter):
    """Text stays text, also what such sites would make a mention, a link or mathematics of."""

    def escape(self, text: str, parent_tags: set[str]) -> str:
        parts = (_OPENING.sub(r"\1\\\2", markdown_text(part)) or " " for part in _EDGES.split(text) if part)
        return "".join(parts)

    def convert_caption(self, el: Tag, text: str, parent_tags: set[str]) -> str:
        return f"\n\n**{text.strip()}**\n\n"


def as_markdown(page: str) -> str:
    """The main part of a page, without signs that only decorate it."""
    (main,) = BeautifulSoup(page, "html.parser")("main")
    for sign in main.select("[aria-hidden]"):
        sign.decompose()
    text = _Converter(heading_style=ATX, sub_symbol="<sub>").convert_soup(main)
    return f"{text.strip()}\n"
