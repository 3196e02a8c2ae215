"""An HTML page as the tests read it: its text, headings, attributes and tables; and what it says as it is kept."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from difflib import unified_diff
from html import unescape
from html.parser import HTMLParser
from itertools import takewhile
from pathlib import Path

from msgspec import Struct, field

from vireport.report.rendering import render_files
from vireport.report.templates import AnyReport

KEPT = Path(__file__).parent / "read"
"""What pages say, a file for each."""

UNREAD = re.compile(r"<(style|script|pre|nav|head)\b.*?</\1>", re.DOTALL)
"""What is no sentence, and what stands elsewhere on the page."""

DRAWING = re.compile(r"<svg\b(.*?)>(.*?)</svg>", re.DOTALL)
BLOCK = re.compile(
    r"</?(h\d|p|li|caption|tr|table|figcaption|div|dt|dd|summary|ul|dl|header|footer|a|figure|text)\b[^>]*>"
)

UNSTEADY = {
    r"\b(?<!\.)[0-9a-f]{16,64}\b": "(digest)",
    r"(\| (vireport|Python|Libraries|Command) \| ).*": r"\1(of this run)",
    r"vireport \d[\w.]*": "vireport (version)",
    r"residual (0|\d(\.\d+)? × 10⁻¹\S)(?=,)": "residual (rounding)",
    r"\d(\.\d+)? × 10⁻1\d": "(rounding)",
    r"\d(\.\d+)? × 10⁻¹\S": "(rounding)",
}
"""What depends on the machine, or on the day."""

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
        self.data = data
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


def lines_of(page: bytes) -> list[str]:
    """What a page says, line by line: a row of a table is one, and so is what stands in a figure for who cannot see."""
    text = UNREAD.sub("", page.decode("utf-8"))
    text = DRAWING.sub(in_words, text)
    text = re.sub(r"<(?!svg\b)[^>]* aria-label=\"(.*?)\"[^>]*>", r"<p>\1</p>", text)
    text = re.sub(r"<t[dh]\b[^>]*>", " | ", text)
    text = re.sub(r"<[^>]*>", "", BLOCK.sub("\n", text))
    lines = map(tidy, unescape(text).replace("\u2060", "").replace("\u00ad", "").split("\n"))
    return [line for line in lines if line]


def in_words(drawing: re.Match[str]) -> str:
    """What stands for a figure in words, and the words in it."""
    alternative = [label.replace("<", "&lt;") for label in re.findall('aria-label="(.*?)"', drawing[1])]
    labels = [
        tidy(label) for label in re.findall(r"<text\b[^>]*>(.*?)</text>", drawing[2]) if re.search("[a-z]{2}", label)
    ]
    return "".join(f"<p>{line}</p>" for line in (*alternative, " | ".join(labels)))


def steady(line: str) -> str:
    """A line without what depends on the machine, or on the day."""
    for pattern, instead in UNSTEADY.items():
        line = re.sub(pattern, instead, line)
    return line


def without_numbers(line: str) -> str:
    return re.sub(r"\d+(?:[.,]\d+)*(?: × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?", "0", line)


def kept_lines(name: str) -> list[str]:
    """What is kept of a page."""
    return (KEPT / f"{name}.txt").read_text(encoding="utf-8").splitlines()


def read_back(name: str, said: Sequence[str], part: str = "") -> list[str]:
    """Where what is said differs from what is kept in `read/`; with WRITE_PAGES set, it is kept as it is said now.

    A part is what stands below its name, up to an empty line.
    """
    said = [steady(tidy(line)) for line in said]
    if os.environ.get("WRITE_PAGES"):
        _keep(name, said, part)
    kept = kept_lines(name)
    if part:
        kept = list(takewhile(bool, kept[kept.index(f"[{part}]") + 1 :]))
    return list(unified_diff(kept, said, "kept", "said", "", "", 0, ""))


def _keep(name: str, said: Sequence[str], part: str) -> None:
    file = KEPT / f"{name}.txt"
    text = "".join(f"{line}\n" for line in said)
    if part:
        parts = file.read_text(encoding="utf-8").split("\n\n") if file.is_file() else []
        others = [other.strip("\n") for other in parts if other.strip() and not other.strip().startswith(f"[{part}]\n")]
        text = "\n\n".join(sorted([*others, f"[{part}]\n{text}".strip("\n")])) + "\n"
    file.write_text(text, encoding="utf-8")


def render_html(report: AnyReport) -> bytes:
    """The page of a report."""
    return render_files(report, {"html"})["report.html"]


def render_pdf(report: AnyReport) -> bytes:
    """The PDF of a report."""
    return render_files(report, {"pdf"})["report.pdf"]
