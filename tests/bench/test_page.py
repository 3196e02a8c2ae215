"""The page of the bench in a real browser: its numbers, its reach, what it says where something is wrong."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from browser import Browser, needs_a_browser, needs_axe
from conftest import EXAMPLES
from serving import Served, serving

from vireport.bench.answers import margins_answer, plane_answer, study_answer
from vireport.bench.session import first, loaded_of, opened, start_data
from vireport.bench.widget import one_module
from vireport.scenario.loading import load
from vireport.study.study import analyse
from vireport.text.formatting import percent, rounded_text

pytestmark = [pytest.mark.slow, needs_a_browser]

WIDTHS = (1440, 1024, 390)
SCENARIOS = "inclined", "design-point"
"""With a sweep and without one."""


@pytest.fixture(scope="module", params=SCENARIOS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def opened_once(name: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with serving(EXAMPLES / f"{name}.yaml", tmp_path_factory.mktemp("served")) as served:
        browser = opened_page(served, tmp_path_factory.mktemp("browser"))
        yield browser
        browser.end()
        assert {url for url in browser.asked if not url.startswith(served.address)} == set()


@pytest.fixture
def page(opened_once: Browser) -> Browser:
    """The page as it begins."""
    opened_once.look(1440)
    press(opened_once, "As in the file")
    settled(opened_once)
    return opened_once


SETTLED = """!document.querySelector(".waiting, .message:not([hidden])")
  && !document.querySelector(".now").textContent && document.querySelector(".sentence").textContent !== ''"""
"""Whether all that follows a change is there."""


def settled(page: Browser) -> None:
    until = time.monotonic() + 60
    while not page.run(SETTLED):
        assert time.monotonic() < until, page.run("document.querySelector('.bench').innerText")
        time.sleep(0.05)


def slide(page: Browser, label: str, value: float) -> None:
    """Move a slider, found by what its name begins with."""
    page.run(f"""(() => {{
      const slider = document.querySelector('input[type=range][aria-label^="{label}"]');
      slider.value = {value};
      slider.dispatchEvent(new Event("input", {{ bubbles: true }}));
    }})()""")


def press(page: Browser, name: str) -> None:
    """Press a button by its name."""
    page.run(
        f"[...document.querySelectorAll('.actions button')].find(x => x.textContent === {json.dumps(name)}).click()"
    )


def texts(page: Browser, selector: str) -> list[str]:
    """The texts of the elements that a selector finds."""
    return list(page.run(f"[...document.querySelectorAll({json.dumps(selector)})].map((x) => x.innerText)"))


def test_what_the_page_shows_is_what_a_run_finds(page: Browser, name: str) -> None:
    known = opened(EXAMPLES / f"{name}.yaml")
    for state in ({}, {"device.restitution": 0.46}):
        if state:
            slide(page, "Restitution r", 0.46)
            settled(page)
        study = analyse(loaded_of(known, state), ("json",))
        design = study.to_dict()["design_point"]
        row = next(k for k, there in enumerate(design["admissible"]) if there)
        cells = dict(zip(texts(page, ".card table tbody th"), texts(page, ".card table tbody td"), strict=False))
        assert cells["Motion"].startswith(design["stability"][row])
        exactness = study.verdict.exactness
        assert texts(page, "td[data-name^='Impact velocity']") == [
            f"{rounded_text(design['velocity_bottom'][row], exactness)}, "
            f"{rounded_text(-design['velocity_top'][row], exactness)}"
        ]
        assert texts(page, "td[data-name^='Phase']") == [
            f"{rounded_text(design['phi_bottom_rad'][row], exactness)}, "
            f"{rounded_text(design['phi_top_rad'][row], exactness)}"
        ]
        opening = study.opening.worded()
        assert texts(page, ".sentence") == [opening.sentence]
        assert texts(page, ".said li > span:last-child") == [text for _, text in opening.facts]
        assert texts(page, ".tiles .value") == [tile.value for tile in opening.tiles]
        ends = study.solution.design.limits()
        rows = [row.split("\t")[1:3] for row in texts(page, ".margins tbody tr")]
        assert rows == [
            [
                study.verdict.place(end),
                percent(end.relative, signed=True),
            ]
            for end in ends[:8]
        ]


def test_no_number_of_the_opening_stands_elsewhere(page: Browser, name: str) -> None:
    """Voltage and margin to use are said by tiles; where the motion ends, by the table with its other ends."""
    voltage = next(value for value in texts(page, ".tiles .value") if value.endswith("V"))
    page_text = page.run("document.querySelector('.bench').innerText")
    assert page_text.count(voltage) == 1
    assert "Mean voltage by" not in page_text
    press(page, "Keep this as A")
    assert len(texts(page, "td[data-name^='Mean voltage']")) == 2
    press(page, "Drop A")


def test_the_map_has_ticks_at_their_places_units_and_a_legend(page: Browser, name: str) -> None:
    ranges = {"inclination β [°]": (0, 90), "length s [m]": (0.59, 0.75)}
    assert texts(page, ".map > .name") == ["length s [m]", "inclination β [°]"]
    if name == "inclined":
        for (low, high), (side, size), which in zip(
            ranges.values(), (("left", "width"), ("bottom", "height")), ("across", "up"), strict=True
        ):
            ticks = page.run(f"""(() => {{
              const box = document.querySelector(".plane").getBoundingClientRect();
              return [...document.querySelectorAll(".ticks.{which} span")].map((tick) => {{
                const own = tick.getBoundingClientRect();
                const middle = {{ left: (own.left + own.right) / 2, bottom: (own.top + own.bottom) / 2 }}.{side};
                return [Number(tick.textContent), Math.abs(middle - box.{side}) / box.{size}];
              }});
            }})()""")
            assert len(ticks) >= 3
            for value, share in ticks:
                assert share == pytest.approx((value - low) / (high - low), abs=0.005)
    assert texts(page, ".map .legend .key") == [
        "stable 1:1 motion",
        "unstable only",
        "no 1:1 motion",
        "this design: drag it",
    ]
    keys = ("stable", "unstable", "no")
    colours = page.run(
        f"{json.dumps(keys)}.map((x) => getComputedStyle(document.querySelector(`.${{x}}-cell`), '::before')"
        ".backgroundColor)"
    )
    pixels = page.run("""(() => {
      const raster = document.querySelector(".raster"), { width, height } = raster;
      const { data } = raster.getContext("2d").getImageData(0, 0, width, height);
      const colour = (_, k) => `rgb(${data.slice(4 * k, 4 * k + 3).join(", ")})`;
      return [...new Set(Array.from({ length: width * height }, colour))];
    })()""")
    assert len(set(colours)) == 3
    assert set(pixels) <= set(colours)


def test_a_map_of_other_inputs_than_those_set_is_pale_until_it_is_drawn_again(page: Browser) -> None:
    slide(page, "Length s", 0.65)
    assert not page.run("document.querySelector('.map').parentNode.classList.contains('waiting')")
    slide(page, "Restitution r", 0.47)
    assert page.run("document.querySelector('.map').parentNode.classList.contains('waiting')")
    settled(page)


def test_on_a_phone_the_curve_stays_above_the_slider_that_is_moved(page: Browser, name: str) -> None:
    if name == "design-point":
        page.run("""(() => { const own = document.querySelector('select[aria-label="Input that is swept"]');
          own.value = "frequency_hz"; own.dispatchEvent(new Event("change")); })()""")
        settled(page)
    page.look(390)
    time.sleep(0.3)
    # As a finger pushes the page: the slider comes to the lower part of the screen.
    sliders = ".inputs > .row:not([hidden]) input[type=range]"
    places = page.run(
        f"[...document.querySelectorAll('{sliders}')]"
        """.map((slider) => {
      slider.scrollIntoView({ block: "end" });
      const [curve, own] = [document.querySelector(".near svg.panel"), slider].map((x) => x.getBoundingClientRect());
      return [curve.top, curve.bottom, own.top, own.bottom];
    })"""
    )
    assert len(places) >= 7
    for top, bottom, slider_top, slider_bottom in places:
        assert 0 <= top < bottom <= slider_top < slider_bottom < 901
    assert page.run("document.querySelectorAll('svg.panel').length") == 3
    page.look(1440)
    time.sleep(0.3)
    assert page.run("document.querySelectorAll('.panels svg.panel').length") == 3


@needs_axe
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_its_window_and_can_be_used_by_all(page: Browser, width: int, scheme: str) -> None:
    page.look(width, scheme)
    time.sleep(0.3)
    page.run("document.querySelectorAll('details').forEach(x => { x.open = true; })")
    assert page.overflow() <= 0
    assert page.violations() == []


def test_curves_reach_from_edge_to_edge_and_marks_stand_on_them(page: Browser, name: str) -> None:
    if name == "design-point":
        assert texts(page, ".panels")[0].startswith("Nothing is swept")
        page.run("""(() => { const own = document.querySelector('select[aria-label="Input that is swept"]');
          own.value = "frequency_hz"; own.dispatchEvent(new Event("change")); })()""")
        settled(page)
    assert page.run("document.querySelectorAll('svg.panel').length") == 3
    study = analyse(loaded_of(opened(EXAMPLES / f"{name}.yaml"), {}), ())
    labels = [point.label for point in study.solution.critical_points]
    titles = page.run(
        "[...document.querySelectorAll('svg.panel')[0].querySelectorAll('.event title')].map((x) => x.textContent)"
    )
    if name != "design-point":
        assert sorted(title.partition(" ")[0] for title in titles) == sorted(labels)
    for choice in ("Figure 4: stability", "Figure 7: voltages"):
        page.run(f"""(() => {{ const own = document.querySelector('select[aria-label="Figure"]');
          own.value = "{choice}"; own.dispatchEvent(new Event("change")); }})()""")
        assert page.run("document.querySelectorAll('svg.panel path.curve').length") > 0
    assert page.run("document.querySelectorAll('.at-design').length") > 0


def test_a_hand_that_moves_fast_is_answered_for_where_it_stops(page: Browser, name: str) -> None:
    before = len(page.of("Network.requestWillBeSent"))
    for k in range(60):
        slide(page, "Restitution r", 0.4 + 0.002 * k)
    settled(page)
    assert page.run("""document.querySelector('input[type=number][aria-label^="Restitution r"]').value""") == "0.518"
    asked = [event["params"]["request"] for event in page.of("Network.requestWillBeSent")[before:]]
    states = [json.loads(own["postData"])["state"] for own in asked if own["url"].endswith("first")]
    assert states[-1]["device.restitution"] == 0.518
    # Each goes out when the one before it is answered.
    assert len(states) < 60


def test_changes_are_undone_and_done_again_and_stand_in_the_address(page: Browser) -> None:
    field = """document.querySelector('input[type=number][aria-label^="Restitution r"]').value"""
    was = page.run(field)
    for value in (0.47, 0.48):
        slide(page, "Restitution r", value)
        settled(page)
    key = "(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true, bubbles: true}))"
    page.run(f"document.querySelector('.actions button').dispatchEvent{key}")
    settled(page)
    assert page.run(field) == "0.47"
    press(page, "Redo")
    settled(page)
    assert page.run(field) == "0.48"
    assert page.run("decodeURIComponent(location.hash.slice(1))") == '{"device.restitution":0.48}'
    press(page, "As in the file")
    settled(page)
    assert page.run(field) == was
    page.run("location.hash = encodeURIComponent('{\"device.restitution\":0.45}')")
    time.sleep(0.2)
    settled(page)
    assert page.run(field) == "0.45"


def test_what_cannot_be_is_told_beside_what_was_set(page: Browser) -> None:
    page.run("""(() => { const field = document.querySelector('input[type=number][aria-label^="Restitution r"]');
      field.value = "1.5"; field.dispatchEvent(new Event("change")); })()""")
    until = time.monotonic() + 20
    while not texts(page, ".message:not([hidden])"):
        assert time.monotonic() < until
        time.sleep(0.05)
    (message,) = texts(page, ".message:not([hidden])")
    assert message.startswith("Restitution: ")
    assert "1.5" in message
    assert (
        page.run("""document.querySelector('input[aria-label^="Restitution r"][type=number]').ariaInvalid""") == "true"
    )
    slide(page, "Restitution r", 0.5)
    settled(page)


def test_two_designs_stand_side_by_side(page: Browser, name: str) -> None:
    velocity = "td[data-name^='Impact velocity']"
    (here,) = texts(page, velocity)
    page.run(
        "[...document.querySelectorAll('.actions button')].find((x) => x.textContent === 'Keep this as A').click()"
    )
    slide(page, "Restitution r", 0.45)
    settled(page)
    moved, kept = texts(page, velocity)
    assert kept == here != moved
    press(page, "Change places with A")
    settled(page)
    assert texts(page, velocity) == [here, moved]
    press(page, "Drop A")
    assert texts(page, velocity) == [here]


def one(tmp_path: Path, scenario: str, *options: str) -> Any:
    return serving(EXAMPLES / f"{scenario}.yaml", tmp_path, *options)


def opened_page(served: Served, tmp_path: Path, state: dict[str, Any] | None = None) -> Browser:
    browser = Browser(tmp_path / "profile")
    browser.look(1440)
    browser.visit(served.address + (f"#{quote(json.dumps(state))}" if state else ""))
    settled(browser)
    return browser


def test_a_design_that_falls_short_is_mended_by_one_click(tmp_path: Path) -> None:
    state = {"device.length_m": 0.6, "requirements.margin_any_percent": 5}
    with one(tmp_path, "inclined") as served:
        page = opened_page(served, tmp_path, state)
        assert texts(page, ".sentence") == ["It does not run: no 1:1 motion is stable."]
        until = time.monotonic() + 60
        while not texts(page, "button.change") and time.monotonic() < until:
            time.sleep(0.1)
        page.run("document.querySelector('button.change').click()")
        settled(page)
        assert texts(page, ".sentence")[0].startswith("It runs")
        assert texts(page, "tr.good td")[-1] == "met"
        page.end()


def test_the_point_of_the_map_is_dragged_and_moved_by_keys(tmp_path: Path) -> None:
    with one(tmp_path, "inclined") as served:
        page = opened_page(served, tmp_path)
        box = page.run("""(() => {
          const field = document.querySelector(".plane");
          field.scrollIntoView({block: "center"});
          const box = field.getBoundingClientRect();
          return [box.left, box.top, box.width, box.height];
        })()""")
        x, y = box[0] + box[2] / 3, box[1] + box[3] / 4
        for kind in ("mousePressed", "mouseReleased"):
            page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        settled(page)
        value = """(label) => Number(document.querySelector(`input[type=number][aria-label^="${label}"]`).value)"""
        assert page.run(f"({value})('Inclination')") == pytest.approx(30, abs=0.5)
        assert page.run(f"({value})('Length')") == pytest.approx(0.71, abs=0.002)
        page.press("ArrowRight", 39)
        settled(page)
        assert page.run(f"({value})('Inclination')") == pytest.approx(30.9, abs=0.5)
        page.end()


def test_a_report_is_written_and_can_be_read(tmp_path: Path) -> None:
    with one(tmp_path, "stiff-membrane") as served:
        page = opened_page(served, tmp_path, {"device.length_m": 0.8})
        press(page, "Save, and write its report")
        until = time.monotonic() + 60
        while not (link := page.run("document.querySelector('.told a')?.href")):
            assert time.monotonic() < until
            time.sleep(0.1)
        assert load(tmp_path / "stiff-membrane-2.yaml").scenario.device.length_m == 0.8
        page.visit(link)
        assert page.run("document.querySelector('h1').textContent") != ""
        assert page.run("document.querySelectorAll('svg.figure').length") > 2
        page.end()


def test_measured_motions_stand_among_the_curves(tmp_path: Path) -> None:
    with one(tmp_path, "measured-sweep") as served:
        page = opened_page(served, tmp_path)
        known = [
            at
            for at in analyse(EXAMPLES / "measured-sweep.yaml", ("json",)).to_dict()["measured"]
            if at["word"] == "BT"
        ]
        drawn = page.run("[...document.querySelectorAll('svg.panel')].map(x => x.querySelectorAll('.measured').length)")
        assert drawn == [2 * len(known), 2 * len(known), 0]
        page.end()


def test_where_the_program_has_ended_the_page_says_so_and_keeps_its_state(tmp_path: Path) -> None:
    with one(tmp_path, "inclined") as served:
        page = opened_page(served, tmp_path)
        slide(page, "Restitution r", 0.47)
        settled(page)
    slide(page, "Restitution r", 0.46)
    until = time.monotonic() + 20
    while not texts(page, ".message:not([hidden])"):
        assert time.monotonic() < until
        time.sleep(0.05)
    assert texts(page, ".message:not([hidden])")[0].startswith(
        "There is no answer: the program behind this page has ended"
    )
    assert page.run("decodeURIComponent(location.hash.slice(1))") == '{"device.restitution":0.47}'
    page.process.terminate()
    page.process.wait()


def test_without_scripts_a_sentence_says_what_to_do(tmp_path: Path) -> None:
    with one(tmp_path, "inclined") as served:
        page = Browser(tmp_path / "profile")
        page.call("Emulation.setScriptExecutionDisabled", value=True)
        page.visit(served.address)
        root = page.call("DOM.getDocument", depth=-1)["root"]
        assert "The bench needs scripts" in json.dumps(root)
        page.end()


MODEL = """
const handlers = {}, sent = [];
window.model = {
  values: { start: START, state: {} },
  get(name) { return this.values[name]; },
  set(name, value) { this.values[name] = value; },
  save_changes() { this.saved = { ...this.values.state }; },
  on(name, handler) { handlers[name] = handler; },
  off(name) { delete handlers[name]; },
  send({ number, kind, question }) {
    sent.push([kind, question.state]);
    const known = ANSWERS[kind];
    setTimeout(() => {
      handlers["msg:custom"]({ number: number + 1000, answer: { refused: [{ path: "", message: "of another" }] } });
      if (kind === "study") handlers["msg:custom"]({ number, progress: "looking" });
      handlers["msg:custom"]({ number, answer: known });
    }, 1);
  },
};
window.sent = sent;
window.handlers = handlers;
window.ended = widget.render({ model, el: document.getElementById("cell") });
"""
"""Stands for the model that a notebook gives a widget; its kernel has answered before."""


def test_the_same_page_speaks_to_a_kernel(tmp_path: Path) -> None:
    known = opened(EXAMPLES / "inclined.yaml")
    study = analyse(loaded_of(known, {}), ("json",))
    answers = {
        "first": first(known, {}),
        "margins": margins_answer(loaded_of(known, {})),
        "study": study_answer(study),
        "plane": plane_answer(study.loaded, ("inclination_deg", "length_m"), ((0.0, 90.0), (0.59, 0.75))),
        "changes": {"changes": None},
    }
    code = one_module().replace("export default", "const widget =")
    model = MODEL.replace("START", json.dumps(start_data(known))).replace("ANSWERS", json.dumps(answers))
    page_file = tmp_path / "cell.html"
    text = f"<!DOCTYPE html><meta charset=utf-8><div id=cell></div><script>{code}\n{model}</script>"
    page_file.write_text(text.replace("</p>", "<\\/p>"), encoding="utf-8")
    page = Browser(tmp_path / "profile")
    page.look(1440)
    page.open(page_file)
    settled(page)
    assert texts(page, ".sentence") == [study.opening.worded().sentence]
    assert [kind for kind, _ in page.run("sent")] == ["margins", "first", "plane", "study", "changes"]
    assert texts(page, ".actions button:not([hidden])") == [
        "Undo",
        "Redo",
        "As in the file",
        "Keep this as A",
    ]  # nothing is saved
    slide(page, "Restitution r", 0.46)
    settled(page)
    assert page.run("model.saved") == {"device.restitution": 0.46}
    page.run("model.values.state = {}; handlers['change:state']()")
    settled(page)
    assert page.run("sent.at(-1)") == ["changes", {}]
    page.run("ended()")
    assert page.run("Object.keys(handlers)") == []
    page.close()


def test_a_margin_of_five_per_cent_is_required_and_reached(tmp_path: Path) -> None:
    """From an example to a better design, by what the page offers."""
    with one(tmp_path, "inclined") as served:
        page = opened_page(served, tmp_path)
        page.run("""(() => {
          const choice = document.querySelector('select[aria-label="Require …"]');
          choice.closest("details").open = true;
          choice.value = "requirements.margin_any_percent";
          choice.dispatchEvent(new Event("change"));
          const field = document.activeElement;
          field.value = "5";
          field.dispatchEvent(new Event("change"));
        })()""")
        settled(page)
        assert texts(page, ".sentence")[0].endswith("but does not meet its requirements.")
        until = time.monotonic() + 60
        while not texts(page, "button.change") and time.monotonic() < until:
            time.sleep(0.1)
        assert texts(page, "button.change")[0].startswith("↑ frequency f to 2.00")
        page.run("document.querySelector('button.change').click()")
        settled(page)
        assert texts(page, "tr.good td")[-1] == "met"
        press(page, "Save as scenario")
        while not texts(page, ".told") or "Saved" not in texts(page, ".told")[0]:
            assert time.monotonic() < until
            time.sleep(0.05)
        page.end()
    study = analyse(tmp_path / "inclined-2.yaml", ())
    assert [line.passed for line in study.criteria] == [True]
    assert study.solution.device.frequency_hz > 2
