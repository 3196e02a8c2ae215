"""The site of the documentation, where `make site` has made it: in a browser, for readers with other senses as well."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Browser, needs_a_browser, needs_axe

SITE = Path(__file__).resolve().parent.parent / "build" / "site"
ALIKE = "python-"
"""What the names of pages begin with that are made alike, of which one is enough."""

OF_WIDTH = ("scrollable-region-focusable",)
"""Rules that a narrow window may break where a wide one does not."""

pytestmark = [
    pytest.mark.slow,
    needs_a_browser,
    needs_axe,
    pytest.mark.skipif(not SITE.is_dir(), reason="there is no site: make site"),
]


def pages() -> Iterator[Path]:
    """One page of each kind that is made, and all that are written."""
    every = sorted(SITE.rglob("*.html"))
    yield from (page for page in every if not page.name.startswith(ALIKE))
    yield from [page for page in every if page.name.startswith(ALIKE)][:1]


def test_every_page_of_the_site_can_be_used_by_all(tmp_path: Path) -> None:
    browser, wrong = Browser(tmp_path / "profile"), {}
    for page in pages():
        browser.open(page)
        browser.look(1440)
        found = browser.violations()
        browser.look(390)
        found += browser.violations(*OF_WIDTH)
        if browser.overflow() > 0:
            found.append(("overflow", [str(browser.overflow())]))
        if found:
            wrong[page.relative_to(SITE).as_posix()] = found
    browser.process.terminate()  # what the theme says on the console is not ours
    browser.process.wait()
    assert wrong == {}
