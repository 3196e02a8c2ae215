"""Makes the site of the documentation in `build/site`, of which `index.html` opens without a server or a network.

    python tools/make_site.py

Sphinx builds it from README.md, `docs/*.md`, and pages that stand nowhere else but are written here from what the
program itself knows: terms, alerts, and the public names of each package. Warnings, such as a link
that leads nowhere, are errors.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from importlib import import_module
from inspect import isclass, isfunction
from pathlib import Path

import vireport
from vireport.text.alerts import CATALOGUE
from vireport.text.terms import TERMS

ROOT = Path(__file__).resolve().parent.parent
MADE = ROOT / "docs" / "made"
SITE = ROOT / "build" / "site"
PACKAGES = (
    *("scenario", "study", "study.judging", "motions", "design", "physics"),
    *("findings.outcomes", "comparison", "map.chart", "optimise"),
)
"""Those whose records a user of `vireport.analyse` and its neighbours comes to hold."""

ACCESSIBLE = {
    '<p class="caption" role="heading">': '<p class="caption" role="heading" aria-level="2">',
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Pages">',
    '<aside class="toc-drawer">': '<aside class="toc-drawer" aria-label="On this page">',
    "<pre>": '<pre tabindex="0">',
    '<div class="table-wrapper colwidths-auto docutils container">': (
        '<div class="table-wrapper colwidths-auto docutils container" tabindex="0">'
    ),
    '</noscript>\n\n<div id="search-results">': '</noscript>\n\n<h1>Search</h1>\n<div id="search-results">',
}
"""Tags as the theme writes them, and with the level of a heading, the name of a region, focus where they scroll, and
the heading of a page that has none."""


def cell(text: object) -> str:
    """Text as a cell of a table in Markdown, in which nothing is markup."""
    return str(text).replace("\\", "\\\\").replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")


def page_of_terms() -> str:
    """The terms that reports and pages use."""
    lines = ["# Glossary", "", "`vireport explain TERM` prints each on the terminal.", ""]
    for term, meaning in sorted(TERMS.items(), key=lambda entry: entry[0].lower()):
        lines += [cell(term), f": {cell(meaning)}", ""]
    return "\n".join(lines)


def page_of_alerts() -> str:
    """The alerts with their causes and remedies."""
    lines = ["# Alerts", "", "`vireport explain CODE` prints each on the terminal.", ""]
    for known in CATALOGUE:
        lines += [f"## {known.code}: {cell(known.title)}", "", f"Severity: {known.severities}.", ""]
        lines += [cell(known.meaning), "", cell(known.remedy), ""]
    return "\n".join(lines)


def pages_of_names() -> Iterator[tuple[str, str]]:
    """A page for the names that `import vireport` gives, and one for each package whose records they lead to."""
    toc = "\n".join(f"python-{package}" for package in PACKAGES)
    yield "python.md", f"# Python\n\n{_documented('vireport')}\n```{{toctree}}\n:maxdepth: 1\n{toc}\n```\n"
    for package in PACKAGES:
        modules = sorted(file.stem for file in (ROOT / "vireport" / package.replace(".", "/")).glob("[a-z]*.py"))
        parts = [_module_of(f"vireport.{package}.{module}") for module in modules]
        yield f"python-{package}.md", "\n".join([f"# vireport.{package}\n", *parts])


def _module_of(name: str) -> str:
    """What a module defines of classes and functions, but for what `import vireport` gives."""
    things = {label: thing for label, thing in vars(import_module(name)).items() if label not in vireport.__all__}
    public = {label: thing for label, thing in things.items() if not label.startswith("_")}
    kinds = {"class": isclass, "function": isfunction}
    parts = [
        f".. auto{kind}:: {name}.{label}\n"
        for label, thing in public.items()
        for kind, of_kind in kinds.items()
        if of_kind(thing) and thing.__module__ == name
    ]
    return f"## {name}\n\n```{{eval-rst}}\n{''.join(parts)}```\n" if parts else ""


def _documented(module: str, options: str = "") -> str:
    return f"```{{eval-rst}}\n.. automodule:: {module}\n{options}```\n"


def write_pages() -> None:
    """Write the pages that are made, and leave alone those that are as they were: Sphinx reads what is newer."""
    pages = dict(pages_of_names())
    pages |= {"glossary.md": page_of_terms(), "alerts.md": page_of_alerts()}
    MADE.mkdir(exist_ok=True)
    for old in MADE.iterdir():
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        if not (MADE / name).is_file() or (MADE / name).read_text(encoding="utf-8") != text:
            (MADE / name).write_text(text, encoding="utf-8")


def complete() -> None:
    """Write into the pages what the theme leaves out for readers with a keyboard or a screen reader."""
    for page in SITE.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for left_out, whole in ACCESSIBLE.items():
            text = text.replace(left_out, whole)
        page.write_text(text, encoding="utf-8")


def main() -> int:
    """Make the site; returns the exit code of Sphinx."""
    from sphinx.cmd.build import main as sphinx

    write_pages()
    options = ["--quiet", "--fail-on-warning", "--keep-going"]
    folders = ["--conf-dir", str(ROOT / "docs"), "--doctree-dir", str(SITE.parent / "doctrees"), str(ROOT), str(SITE)]
    code = sphinx([*options, *folders])
    if not code:
        complete()
        shutil.copy(SITE / "README.html", SITE / "index.html")
        print(f"{SITE / 'index.html'}")
    return code


if __name__ == "__main__":
    sys.exit(main())
