"""The atlas of a report in a real browser: unstable motions can be hidden."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import Browser, needs_a_browser
from conftest import EXAMPLES

from vireport.cli import main

pytestmark = [pytest.mark.slow, needs_a_browser]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("atlas")
    command = ["run", str(EXAMPLES / "inclined.yaml"), "--set", "motions.impacts=2"]
    assert main([*command, "-o", str(folder), "--format", "html", "-q"]) == 0
    return folder


SEEN = """(unstable => [...document.querySelectorAll('svg[data-figure="figure-atlas"] path')]
    .filter(x => !!x.closest('.unstable') === unstable && x.checkVisibility({visibilityProperty: true})).length)"""

SWITCH = """[...document.querySelectorAll('label.live-control')].find(
    x => x.previousElementSibling.querySelector('[data-figure="figure-atlas"]')).querySelector('input').click()"""


def test_unstable_motions_can_be_hidden(browser: Browser) -> None:
    stable, unstable = (browser.run(f"{SEEN}({word})") for word in ("false", "true"))
    assert stable > 0
    assert unstable > 0
    browser.run(SWITCH)
    assert [browser.run(f"{SEEN}({word})") for word in ("false", "true")] == [stable, 0]
    browser.run(SWITCH)
    assert [browser.run(f"{SEEN}({word})") for word in ("false", "true")] == [stable, unstable]
