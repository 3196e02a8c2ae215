"""The live figures of a report in a real browser: readings, keyboard, links, and nothing from outside."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, needs_a_browser

from vireport.cli import main
from vireport.text import MINUS

ROOT = Path(__file__).resolve().parent.parent.parent
pytestmark = [pytest.mark.slow, needs_a_browser]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("live")
    assert (
        main(["run", str(ROOT / "examples" / "horizontal.yaml"), "-o", str(folder), "--format", "html,json", "-q"]) == 0
    )
    return folder


READ = """Object.fromEntries([...document.querySelectorAll(".live dd")].map(x => [x.dataset.name, x.textContent]))"""


def test_readings_are_those_of_the_results(folder: Path, browser: Browser) -> None:
    branches = json.loads((folder / "results.json").read_text())["branches"]
    known = {branch["number"]: branch for branch in branches}
    checked = 0
    for option in range(browser.run("document.querySelectorAll('.live-control select')[0].options.length")):
        name = browser.run(f"document.querySelector('.live-control select').options[{option}].text")
        branch = known[int(name.split()[1].rstrip(","))]
        browser.run(f"""(() => {{ const choice = document.querySelector('.live-control select');
            choice.value = {option}; choice.dispatchEvent(new Event('change')); }})()""")
        last = int(browser.run("document.querySelector('.live-control input').max"))
        for row in {round(k * last / 14) for k in range(15)}:
            browser.run(f"""(() => {{ const slider = document.querySelector('.live-control input');
                slider.value = {row}; slider.dispatchEvent(new Event('input')); }})()""")
            read = {key: text.replace(MINUS, "-") for key, text in browser.run(READ).items()}
            shared = [(float(text), branch[key]) for key, text in read.items() if key in branch]
            rows = range(len(branch["d"]))
            same = [k for k in rows if all(shown == float(f"{exact[k]:.5g}") for shown, exact in shared)]
            assert same, (name, row)
            multipliers = [read[f"multiplier_{k}"] for k in (1, 2)]
            if not any("i" in text for text in multipliers):
                product, total = (float(multipliers[0]) * float(multipliers[1]), sum(map(float, multipliers)))
                assert product == pytest.approx(branch["determinant"][same[0]], rel=1e-3)
                assert total == pytest.approx(branch["trace"][same[0]], rel=1e-4, abs=1e-5)
            else:
                assert " - " in multipliers[1]
            checked += 1
    assert checked >= 50


def test_the_crosshair_is_one_in_all_panels_and_lies_on_the_curves(browser: Browser) -> None:
    browser.run("""(() => { const slider = document.querySelectorAll('.live-control input')[2];
        slider.value = 40; slider.dispatchEvent(new Event('input')); })()""")
    places = browser.run("""[...document.querySelectorAll('svg.wide .cross')].map(cross => [
        cross.parentNode.dataset.figure, cross.getAttribute('visibility'), cross.querySelectorAll('circle').length])""")
    assert sorted(places) == [["figure-2", "visible", 6], ["figure-4", "visible", 3], ["figure-7", "visible", 3]]
    assert browser.run("[...document.querySelectorAll('.live-control input')].map(x => x.value)") == ["40"] * 3


def test_on_a_narrow_screen_the_crosshair_lies_on_the_curves_too(browser: Browser) -> None:
    browser.look(390)
    browser.run("""(() => { const slider = document.querySelectorAll('.live-control input')[0];
        slider.value = 60; slider.dispatchEvent(new Event('input')); })()""")
    drawings = browser.run("""[...document.querySelectorAll('svg.narrow:has(.cross)')].map(svg => [
        [...svg.querySelectorAll('.cross circle')].map(x => [x.getAttribute('cx'), x.getAttribute('cy')].map(Number)),
        [...svg.querySelectorAll('path[d][clip-path]')].map(x => x.getAttribute('d'))])""")
    assert [len(dots) for dots, _ in drawings] == [6, 3, 3]
    for dots, paths in drawings:
        curves = [path.replace("L", "") for path in paths if not set("Cz") & set(path)]
        pieces = [piece.split() for path in curves for piece in path.split("M")]
        lines = [np.array(piece, float).reshape(-1, 2) for piece in pieces if len(piece) > 2]
        starts, ends = (np.concatenate([line[part] for line in lines]) for part in (np.s_[:-1], np.s_[1:]))
        for dot in dots:
            along = ends - starts
            share = ((dot - starts) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-9)
            assert np.hypot(*(starts + np.clip(share, 0, 1)[:, None] * along - dot).T).min() < 0.5
    inside = browser.run("""(() => { const svg = document.querySelector('svg.narrow[data-figure="figure-2"]');
        const dot = svg.querySelectorAll('.cross circle')[2].getBoundingClientRect();
        const at = {bubbles: true, clientX: dot.x + dot.width / 2, clientY: dot.y + dot.height / 2};
        svg.dispatchEvent(new PointerEvent('pointermove', at));
        return document.querySelector('.live-control input').value; })()""")
    assert inside == "60"
    browser.look(1440)


def test_the_keyboard_moves_the_crosshair_and_reaches_the_buttons(browser: Browser) -> None:
    browser.run("document.querySelector('.live-control input').focus()")
    before = browser.run(READ)["d"]
    browser.press("ArrowRight", 39)
    assert browser.run(READ)["d"] != before
    names = []
    for _ in range(2):
        browser.press("Tab", 9)
        names.append(browser.run("document.activeElement.textContent"))
    assert names == ["Play", "Close"]


def test_the_pointer_picks_the_nearest_motion_and_a_critical_point_leads_to_its_row(browser: Browser) -> None:
    shown = browser.run("""(() => { const data = JSON.parse(document.getElementById('live-data').textContent);
        const branch = data.branches.find(x => Object.values(x.labels).includes('B1'));
        const row = Object.keys(branch.labels).find(i => branch.labels[i] === 'B1');
        const svg = document.querySelector('svg[data-figure="figure-2"]');
        const [across, ...curves] = branch.places['figure-2'];
        const place = new DOMPoint(across[row], curves[2][row]).matrixTransform(svg.getScreenCTM());
        const at = {bubbles: true, clientX: place.x, clientY: place.y};
        svg.dispatchEvent(new PointerEvent('pointermove', at));
        svg.dispatchEvent(new MouseEvent('click', at));
        return [document.querySelector('.live strong').textContent, location.hash]; })()""")
    assert shown[0].endswith("B1")
    assert shown[1] == "#point-B1"


def test_the_ball_is_on_the_membranes_at_the_impacts(browser: Browser) -> None:
    browser.run("""(() => { const slider = document.querySelectorAll('.live-control input')[0];
        slider.value = 40; slider.dispatchEvent(new Event('input')); })()""")
    assert browser.run("document.querySelector('.live .bottom').classList.contains('struck')")
    ball, wall = (
        browser.run(f"Number(document.querySelector('.live {name}').getAttribute('{at}'))")
        for name, at in ((".ball", "cx"), (".bottom", "x1"))
    )
    assert ball - wall == pytest.approx(5.0, abs=0.1)


PLAYED = """new Promise(done => {
    const panel = document.querySelector('.live'), seen = [], at = (name, key) =>
        Number(panel.querySelector(name).getAttribute(key));
    [...panel.querySelectorAll('button')].find(x => x.textContent === 'Play').click();
    const watch = () => {
        seen.push([(at('.bottom', 'x1') + at('.top', 'x1')) / 2, (at('.top', 'x1') - at('.bottom', 'x1')) / 2,
                   at('.ball', 'cx')]);
        if (seen.length < 200) requestAnimationFrame(watch); else done(seen);
    };
    watch(); })"""


def test_what_plays_is_the_flight_between_the_membranes(browser: Browser) -> None:
    browser.run("""(() => { const slider = document.querySelectorAll('.live-control input')[0];
        slider.value = 40; slider.dispatchEvent(new Event('input')); })()""")
    data = json.loads(browser.run("document.getElementById('live-data').textContent"))
    played = np.array(browser.run(PLAYED))
    known = data["branches"][browser.run("Number(document.querySelector('.live-control select').value)")]["columns"]
    q, d, phase = (known[name][40] for name in ("q", "d", "phi_bottom_rad"))
    times = np.linspace(0, 2, 4001)
    up = times < 2 * q
    begin, first = np.where(up, 0.0, 2 * q), np.where(up, phase, known["phi_top_rad"][40])
    after = np.where(up, known["after_bottom"][40], known["after_top"][40])
    t, last = times - begin, np.pi * times + phase
    z = (
        np.where(up, d / 2, -d / 2)
        + after * t
        + np.where(up, *(known[f"gravity_{w}"][40] for w in ("bottom", "top"))) * (t**2 / 2)
    )
    z += -(np.cos(last) - np.cos(first)) / np.pi**2 - np.sin(first) * t / np.pi
    scale = 170 / (d + 2 / np.pi**2)
    centre, ball = -np.cos(last) / np.pi**2 * scale, -z * scale * (1 - 5 / (d / 2 * scale))
    assert played[:, 1] == pytest.approx(np.full(len(played), d / 2 * scale), rel=1e-4)
    far = np.hypot(centre - played[:, :1], ball - (played[:, 2:] - played[:, :1])).min(axis=1)
    assert far.max() < 0.15  # of 170 across: the times are dense, the readings rounded
    assert np.ptp(played[:, 2]) > 30
