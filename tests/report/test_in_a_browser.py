"""Pages of all commands that write one, in a browser: wide and narrow, light and dark, printed."""

from __future__ import annotations

from base64 import b64decode
from io import BytesIO
from itertools import product
from pathlib import Path
from unicodedata import normalize

import pytest
from browser import Browser, needs_a_browser, needs_axe
from conftest import EXAMPLES, SHORTEST, WITHOUT
from pages import squeeze
from PIL import Image, ImageStat
from pypdf import PdfReader

from vireport.cli.app import main

NAMES = ("inclined", "horizontal", "simulated", "design-point", "best-design", "ci/failing")
"""All but those that have the sections and figures of another one."""

WIDTHS = (1440, 1024, 390)
LEGIBLE = 9.0
"""Least size of the type in a figure, however narrow the window [px]."""

PAPER = {"light": (200, 256), "dark": (0, 60)}
"""Mean brightness of a page."""

PIXELS = 30
"""By how much a heat map makes a page brighter: its colours mean something, and no dark page exchanges them."""

pytestmark = [pytest.mark.slow, needs_a_browser]


@pytest.fixture(scope="module", params=[*NAMES, "comparison", "chart", "map", "identify", "optimise"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    name, folder = request.param, tmp_path_factory.mktemp("page")
    command = ["run", str(EXAMPLES / f"{name}.yaml")]
    if name == "comparison":
        command = ["compare", str(EXAMPLES / "inclined.yaml"), "--vary", "inclination_deg=0,45"]
    if name == "chart":
        over = "restitution=0.4..0.6,length_m=0.5..0.8"
        command = ["map", str(EXAMPLES / "inclined.yaml"), "--over", over, "--set", "motions.impacts=3"]
    if name == "map":
        text = (EXAMPLES / "maps" / "map.yaml").read_text(encoding="utf-8")
        text = text.replace("count: 60", "count: 12").replace("count: 80", "count: 16")
        (folder / "map.yaml").write_text(f"{text}  from_rest: true\n  shock: true\n", encoding="utf-8")
        command = ["map", str(folder / "map.yaml")]
    if name == "identify":
        record = str(EXAMPLES / "records" / "prototype.wav")
        command = ["identify", str(EXAMPLES / "measured.yaml"), "--record", record]
    if name == "optimise":
        command = ["optimise", str(EXAMPLES / "best-design.yaml"), "--set", f"design={SHORTEST}"]
        command += ["--set", f"requirements={WITHOUT}"]
    assert main([*command, "-o", str(folder), "--format", "html", "-q"]) == (name == "ci/failing")
    return folder


OVERLAPS = """(() => {
  const parts = [...document.querySelectorAll(
    "h1, h2, h3, p, dt, dd, th, td, caption, figcaption, pre, select, input, button, svg.figure")]
    .filter(x => x.checkVisibility() && !x.closest(".skip")).map(node => {
      const box = node.getBoundingClientRect(), scroll = node.closest(".scroll")?.getBoundingClientRect();
      return {node, top: box.top, bottom: box.bottom, left: Math.max(box.left, scroll?.left ?? -1e9),
        right: Math.min(box.right, scroll?.right ?? 1e9)};
    }).filter(x => x.right - x.left > 1).sort((a, b) => a.top - b.top);
  const found = [];
  parts.forEach((a, i) => {
    for (const b of parts.slice(i + 1)) {
      if (b.top > a.bottom - 2) break;
      const within = a.node.contains(b.node) || b.node.contains(a.node);
      if (!within && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2)
        found.push([a.node.textContent.slice(0, 40), b.node.textContent.slice(0, 40)]);
    }
  });
  return found;
})()"""

SMALLEST = """Math.min(...[...document.querySelectorAll("svg.figure")].filter(x => x.checkVisibility())
  .flatMap(svg => [...svg.querySelectorAll("text")]
  .map(text => parseFloat(getComputedStyle(text).fontSize) * svg.getScreenCTM().a)))"""

CUT = """[...document.querySelectorAll(".scroll:has(table)")].filter(x => x.checkVisibility()
  && x.scrollWidth > x.clientWidth).map(x => x.textContent.slice(0, 40))"""
"""Tables whose last columns are out of sight."""

BEYOND = """[...document.querySelectorAll("svg.figure")].filter(x => x.checkVisibility()).map(
  x => x.parentNode.scrollWidth - x.parentNode.clientWidth)"""


@pytest.mark.parametrize("width", WIDTHS)
def test_it_fits_the_window_and_nothing_lies_on_anything(width: int, browser: Browser, folder: Path) -> None:
    for scheme, (dark, light) in PAPER.items():
        picture = browser.look(width, scheme)
        (folder / f"{width}-{scheme}.png").write_bytes(picture)
        (brightness,) = ImageStat.Stat(Image.open(BytesIO(picture)).convert("L")).mean
        assert dark < brightness < light + PIXELS * (folder / "map.yaml").exists()
    browser.run("document.querySelectorAll('details').forEach(x => { x.open = true; })")
    assert browser.overflow() <= 0
    assert browser.run(OVERLAPS) == []
    assert browser.run(SMALLEST) >= LEGIBLE
    if width == WIDTHS[0]:
        assert browser.run(CUT) == []


def test_each_figure_is_there_once_and_only_a_narrow_screen_scrolls_it(browser: Browser) -> None:
    browser.run("document.querySelectorAll('details').forEach(x => { x.open = true; })")
    names = browser.run("[...document.querySelectorAll('svg.figure')].map(x => x.dataset.figure)")
    assert len(set(names)) == len(names) > 0
    for width in WIDTHS:
        browser.look(width)
        beyond = browser.run(BEYOND)
        assert len(beyond) == len(names)
        assert all(pixels > 0 for pixels in beyond) if width == 390 else not any(beyond)


def test_the_keyboard_reaches_everything(browser: Browser) -> None:
    browser.look(1440)
    wanted = browser.run("""(() => {
        window.stops = [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex='0']")]
            .filter(x => x.checkVisibility());
        window.reached = new Set();
        document.addEventListener("focusin", event => window.reached.add(event.target));
        document.activeElement.blur();
        return window.stops.length; })()""")
    assert wanted > 5
    for _ in range(wanted + 2):
        browser.press("Tab", 9)
    missed = "window.stops.filter(x => !window.reached.has(x)).map(x => x.outerHTML.slice(0, 80))"
    assert browser.run(missed) == []


@needs_axe
def test_axe_finds_no_violation(browser: Browser) -> None:
    browser.run("document.querySelectorAll('details').forEach(x => { x.open = true; })")
    for width, scheme in product((WIDTHS[0], WIDTHS[-1]), PAPER):
        browser.look(width, scheme)
        assert browser.violations() == [], (width, scheme)


def test_printed_everything_is_open(browser: Browser) -> None:
    browser.look(1440)
    browser.run("document.querySelectorAll('details').forEach(x => { x.open = false; })")
    headings = browser.run("[...document.querySelectorAll('h2, h3')].map(x => x.textContent)")
    pdf = browser.call("Page.printToPDF", preferCSSPageSize=True)["data"]
    text = "".join(page.extract_text() for page in PdfReader(BytesIO(b64decode(pdf))).pages)
    text = squeeze(normalize("NFKC", text))  # without ligatures
    assert [heading for heading in headings if squeeze(heading) not in text] == []


def test_without_scripts_all_is_readable(browser: Browser, folder: Path) -> None:
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.open(folder / "report.html")
    for width in WIDTHS:
        browser.look(width)
        assert browser.overflow() <= 0
    assert browser.run("document.querySelectorAll('svg.figure').length") > 0
