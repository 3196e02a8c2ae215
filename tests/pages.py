"""An HTML page as the tests read it: its text, headings, attributes and tables."""

from __future__ import annotations

import re
from html.parser import HTMLParser

from msgspec import Struct, field

INLINE = ("a", "b", "code", "em", "span", "strong", "sub")
VOID = ("meta", "link", "img", "br")


def tidy(text: str) -> str:
    return " ".join(text.replace("\u00a0", " ").split())


def squeeze(text: str) -> str:
    """Without spaces, which a PDF's text has where its lines break."""
    return re.sub(r"\s", "", text.replace("\u00ad", ""))


class HtmlTable(Struct):
    rows: list[list[str]] = field(default_factory=list)
    caption: str = ""

    def columns(self, *titles: str) -> list[tuple[str, ...]]:
        """Columns by their titles; one that stands twice is told apart by a trailing number."""
        names: list[str] = []
        for title in self.rows[0]:
            count = self.rows[0][: len(names)].count(title)
            names.append(f"{title} {count + 1}" if count else title)
        return [tuple(row[names.index(title)] for title in titles) for row in self.rows[1:]]


class Page(HTMLParser):
    """What stands on a page; of its opening the facts, with status, and the tiles: status, label, number, remark."""

    def __init__(self, data: bytes) -> None:
        super().__init__(convert_charrefs=True)
        self.parts: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.headings: list[str] = []
        self.all_tables: list[HtmlTable] = []
        self.open: list[str] = []
        self.of_facts = False
        self.said: list[list[str]] = []
        self.tiles: list[list[str]] = []
        self.feed(data.decode("utf-8"))
        self.text = tidy("".join(self.parts))

    @property
    def tables(self) -> dict[str, HtmlTable]:
        return {table.caption: table for table in self.all_tables}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.parts.append("" if tag in INLINE else " ")
        if tag not in VOID:
            self.open.append(tag)
        if tag == "h2":
            self.headings.append("")
        elif tag in ("ul", "ol"):
            self.of_facts = dict(attrs).get("class") == "said"
        elif tag == "li" and self.of_facts:
            self.said.append([dict(attrs)["class"] or "", ""])
        elif tag == "div" and "dl" in self.open:
            self.tiles.append([dict(attrs)["class"] or ""])
        elif tag in ("dt", "dd") and self.tiles:
            self.tiles[-1].append("")
        elif tag == "table":
            self.all_tables.append(HtmlTable())
        elif tag == "tr":
            self.all_tables[-1].rows.append([])
        elif tag in ("th", "td"):
            self.all_tables[-1].rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        while self.open and self.open.pop() != tag:
            pass
        self.parts.append("" if tag in INLINE else " ")

    def handle_data(self, data: str) -> None:
        if "style" in self.open or "script" in self.open:
            return
        self.parts.append(data)
        plain = data.replace("\u00a0", " ")
        if "h2" in self.open:
            self.headings[-1] += plain
        elif "ul" in self.open and self.of_facts:
            self.said[-1][-1] += plain
        elif "dl" in self.open:
            self.tiles[-1][-1] += plain
        elif "caption" in self.open:
            self.all_tables[-1].caption += plain
        elif "td" in self.open or "th" in self.open:
            self.all_tables[-1].rows[-1][-1] += plain

    def attributes(self, name: str) -> list[str]:
        return [attributes[name] or "" for _, attributes in self.tags if name in attributes]
