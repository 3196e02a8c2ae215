"""Regions of charts: what is stable in them, the design point with its margins, figure, files and reports."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES
from exact import printed_maps, printed_trace
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from mpmath import mp, mpf
from msgspec import convert
from pages import Page, kept_lines, lines_of, read_back, tidy, without_numbers

from vireport import analyse, load
from vireport.base.errors import RenderError
from vireport.cli.app import main
from vireport.design.point import design_point
from vireport.figures.style import LOCI
from vireport.map.chart import outputs
from vireport.map.chart.chart import Chart, PlaneLoci, loci_over, with_regions
from vireport.map.chart.design import BEYOND, charted_design
from vireport.map.chart.figure import EDGE, colored, picture
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.over import chart_of, plane_of
from vireport.map.chart.plane import Cut, DevicePlane, StraightSweep
from vireport.map.chart.regions import (
    PIXELS,
    ROOM,
    ChartRegion,
    NarrowBand,
    Regions,
    StableMotion,
    narrow_bands,
    pieces,
    stable_motions,
)
from vireport.map.chart.results import ChartData
from vireport.map.chart.words import naming
from vireport.map.design import exactness_of
from vireport.map.outputs import MapOutput
from vireport.motions.events import Event
from vireport.motions.pointwise import find_motions
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.groups import map_restitution as of_each
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput
from vireport.study.checks import reference
from vireport.study.judging.opening import WordedOpening
from vireport.study.plan import Task
from vireport.text.templates import Words

SMALL = "restitution=0.4..0.6,length_m=0.55..0.75"
WORD = (2, "BT", 1, False)


@cache
def scenario(name: str) -> Loaded:
    return load(EXAMPLES / f"{name}.yaml")


@cache
def charted(name: str, over: str, impacts: int = 2, periods: int = 1) -> Chart:
    """A chart with its regions, of 1:1 motions alone or of all words."""
    loaded = scenario(name)
    own = plane_of(loaded.scenario, over)
    drawn = loci_over(own, Limits(impacts, periods), cuts=0 if impacts == 2 else 3)
    return with_regions(drawn, Device.of(loaded.scenario))


@cache
def all_words() -> Chart:
    return charted("inclined", "restitution=0.2..0.8,length_m=0.3..1", 4, 2)


CHARTS: list[Callable[[], Chart]] = [
    lambda: charted("inclined", SMALL),
    lambda: charted("inclined", "inclination_deg=0..90,length_m=0.3..1"),
    lambda: charted("horizontal", "restitution=0.3..0.9,length_m=0.1..2"),
    lambda: charted("inclined", "restitution_bottom=0.3..0.7,restitution_top=0.3..0.7"),
]
EACH = [pytest.param(make, marks=[pytest.mark.slow] if n else []) for n, make in enumerate(CHARTS)]


def array_of(groups: Groups[Any]) -> Any:
    """The restitution of one device, or both, as arrays."""
    return of_each(groups.restitution, lambda r: np.array([float(r)]))


def clear(drawn: Chart, inputs: Any) -> bool:
    """Whether a point is farther from all loci than regions are wide at least."""
    plane = drawn.plane
    points = np.concatenate([pieces(locus)[0] for locus in drawn.loci])
    ends = np.concatenate([pieces(locus)[0][pieces(locus)[1].nonzero()[0]] for locus in drawn.loci])
    away = np.abs((np.concatenate([points, ends]) - inputs) / plane.widths).max(axis=1)
    return bool(away.min() > 3 * ROOM / PIXELS)


@pytest.mark.parametrize("make", EACH)
def test_a_region_has_the_motions_that_are_stable_at_any_of_its_points(make: Callable[[], Chart]) -> None:
    """By all 1:1 motions at random devices, in closed form without a sweep, and by all words at some of them."""
    drawn, rng, checked = make(), np.random.default_rng(11), 0
    plane, regions = drawn.plane, drawn.regions
    assert regions is not None
    for n in range(200):
        at = plane.low + plane.widths * rng.uniform(0.01, 0.99, 2)
        if not clear(drawn, at):
            continue
        region = regions.at(at.tolist())
        assert region is not None
        groups = plane.at(at.tolist())
        d, gbar = (np.array([float(group)]) for group in groups[:2])
        found = find_motions(Groups(d, abs(gbar), array_of(groups)), plane.device.period_ratio)
        stable = bool(found.stable(array_of(groups)).any())
        assert stable == any(each.one_to_one for each in region.motions or ()), at
        if n % 20 == 0:
            own = stable_motions(plane, tuple(at.tolist()), drawn.limits)
            assert {each.kind for each in own or ()} == set(region.kinds or ()), at
        checked += 1
    assert checked > 60
    assert sum(region.share for region in regions.every) == pytest.approx(1)
    assert len({region.kinds for region in regions.every}) > 1


@pytest.mark.slow
def test_a_region_has_the_words_that_are_stable_at_any_of_its_points() -> None:
    drawn, rng, checked = all_words(), np.random.default_rng(12), 0
    for at in drawn.plane.low + drawn.plane.widths * rng.uniform(0.01, 0.99, (14, 2)):
        region = drawn.regions.at(at.tolist()) if drawn.regions is not None else None
        if region is None or not clear(drawn, at):
            continue
        own = stable_motions(drawn.plane, tuple(at.tolist()), drawn.limits)
        assert {each.kind for each in own or ()} == set(region.kinds or ()), at
        checked += 1
    assert checked > 4


@pytest.mark.slow
def test_the_margins_of_a_motion_of_another_word_end_where_it_does() -> None:
    """2:1 motion at s = 0.24 m, F = 5 N, f = 2.5 Hz and 30 degrees, which has a grazing point at 0.22104 m."""
    loaded, limits = load(EXAMPLES / "hysteresis.yaml"), Limits(3, 1)
    own = plane_of(loaded.scenario, "restitution=0.45..0.55,length_m=0.235..0.245")
    design = charted_design(Device.of(loaded.scenario), own, limits)
    assert design is not None
    assert [each.kind[1] for each in design.motions or ()] == ["BBT"]
    low, high = (end for end in design.margins if end.axis == 1)
    assert (low.event, round(low.value, 5), high.event) == (Event.GRAZING, 0.22104, Event.FOLD)
    for end in design.margins:
        for side, stable in ((-1e-6, True), (1e-6, False)):
            at = np.array(design.inputs)
            at[end.axis] = end.value + side * np.sign(end.distance)
            words = [each.kind[1] for each in stable_motions(own, tuple(at.tolist()), limits) or ()]
            assert ("BBT" in words) == stable, (end, side)


@pytest.mark.slow
def test_the_motions_of_all_regions_are_those_of_the_printed_maps() -> None:
    drawn = all_words()
    for region in drawn.regions.every if drawn.regions else ():
        for each in region.motions or ():
            motion, (d, gbar, *_) = each.motion, drawn.plane.at(region.inputs)
            x, r = [*motion.velocity.tolist(), *motion.time.tolist()], mpf(region.inputs[0])
            with reference.precise():
                assert max(map(abs, printed_maps(motion.word, x, d, gbar, r))) < 1e-9
            with mp.workdps(150):
                trace = printed_trace(motion.word, list(map(mpf, x)), mpf(d), mpf(gbar), r)
                assert abs(trace - each.trace) < 1e-6
                assert abs(trace) < 1 + r ** (2 * len(motion.word))
            assert each.decay == pytest.approx(float(r) ** len(motion.word))


@pytest.mark.slow
def test_a_horizontal_capsule_has_regions_of_asymmetric_motions() -> None:
    drawn = CHARTS[2]()
    kinds = {kind for region in drawn.regions.every for kind in region.kinds or ()} if drawn.regions else set()
    assert kinds == {(2, "BT", 1, False), (2, "BT", 1, True)}
    for region in drawn.regions.every if drawn.regions else ():
        for each in region.motions or ():
            way = float(each.motion.time[1] - each.motion.time[0])
            assert each.asymmetric == (abs(way - 1) > 1e-6)


@pytest.mark.parametrize("over", [SMALL, pytest.param("length_m,frequency_hz", marks=pytest.mark.slow)])
def test_margins_in_the_chart_are_those_of_a_run(over: str) -> None:
    drawn, device = charted("inclined", over), Device.of(scenario("inclined").scenario)
    design, point = drawn.design, design_point(device, None)
    assert design is not None
    assert [each.kind for each in design.motions or ()] == [WORD]
    for k, varied in enumerate(drawn.plane.inputs):
        for end in (end for end in design.margins if end.axis == k):
            own = [margin for margin in point.margins if margin.parameter is varied and margin.ends_stability]
            nearest = min((m for m in own if m.distance * end.distance > 0), key=lambda m: abs(m.distance))
            assert (end.value, end.event, end.distance) == (nearest.sweep_value, nearest.event, nearest.distance)
            assert end.relative == pytest.approx(nearest.relative)
            there = np.array(design.inputs)
            there[k] = end.value + np.sign(end.distance) * BEYOND * drawn.plane.widths[k]
            groups = drawn.plane.at(there.tolist())
            d, gbar = (np.array([float(group)]) for group in groups[:2])
            motions = find_motions(Groups(d, gbar, array_of(groups)), 1)
            assert bool(motions.stable(array_of(groups)).any()) == bool(end.beyond)
        smallest = design.nearest(k)
        assert smallest is not None
        assert abs(smallest.distance) == min(abs(end.distance) for end in design.margins if end.axis == k)


@pytest.mark.slow
def test_a_device_without_the_inputs_or_outside_has_no_design_point() -> None:
    drawn = charted("inclined", SMALL)
    for changed in ({DesignInput.LENGTH: None}, {DesignInput.LENGTH: 0.76}, {DesignInput.RESTITUTION: 0.39}):
        device = Device.of(scenario("inclined").scenario).with_values(changed)
        assert with_regions(drawn, device).design is None


def stub(kinds: tuple[str, ...], plane: DevicePlane) -> Regions:
    """A plane of one region in which some words are stable."""
    motion = [Motion(Word.of(word), np.ones(len(word)), np.arange(len(word)), 0.4) for word in kinds]
    region = ChartRegion((0.5, 0.6), 1.0, tuple(StableMotion(each, 0.0, 0.1, False) for each in motion))
    return Regions(plane, (region,), np.zeros((PIXELS, PIXELS), dtype=np.intp), ())


def test_what_is_stable_in_a_narrow_range_of_a_sweep_is_a_band() -> None:
    plane = plane_of(scenario("inclined").scenario, SMALL)
    line = StraightSweep(plane, 1, 0.5)
    stable = (
        (0.55, 0.6, ("BT",)), (0.6, 0.6004, ("BBT", "BT")), (0.6004, 0.6005, ("BBT", "BT")), (0.6005, 0.65, ("BT",)),
        (0.65, 0.65 + 5e-8, ("BBT", "BB")), (0.65 + 5e-8, 0.7, ("BT", "BB")),
        (0.7, 0.7499, ("BT",)), (0.7499, 0.75, ("B",)),
    )  # fmt: skip
    (band,) = narrow_bands(stub(("BT",), plane), [Cut(line, stable)])
    assert isinstance(band, NarrowBand)
    assert (band.word, band.varied, band.settable) == ("BBT", 1, True)
    assert (band.least, band.most) == (pytest.approx(5e-8), pytest.approx(5e-4))
    narrow = tuple((low, high, words if high - low < 1e-7 else ("BT",)) for low, high, words in stable)
    assert not narrow_bands(stub(("BT",), plane), [Cut(line, narrow)])[0].settable
    assert narrow_bands(stub(("BT", "BBT"), plane), [Cut(line, stable)]) == ()
    off = [(0.0, 0.0), (0.0, 0.0)]
    off[line.varied] = (11 * band.most, 0.0)
    assert not narrow_bands(stub(("BT",), plane), [Cut(line, stable)], off)[0].settable
    off[line.varied] = (9 * band.most, 0.0)
    assert narrow_bands(stub(("BT",), plane), [Cut(line, stable)], off)[0].settable
    assert narrow_bands(stub(("BT",), plane), [Cut(line, stable)], [off[1], off[0]])[0].settable


def test_a_chart_has_the_tolerances_of_its_inputs(monkeypatch: pytest.MonkeyPatch) -> None:
    own = load(EXAMPLES / "inclined.yaml", {"tolerances": {"length_m": 0.01, "inclination_percent": 2.0}})
    monkeypatch.setattr(
        "vireport.map.chart.over.loci_over", lambda plane, limits, *_, **__: PlaneLoci(plane, limits, (), (), ())
    )
    monkeypatch.setattr(
        "vireport.map.chart.over.with_regions",
        lambda drawn, *_: Chart(drawn.plane, drawn.limits, (), (), (), stub((), drawn.plane)),
    )
    drawn = chart_of(own, "length_m=0.5..0.9,inclination_deg=0..90", lambda what: None)
    assert drawn.tolerances == ((0.01, 0.0), (0.0, 2.0))


@pytest.mark.parametrize("make", EACH)
def test_each_colour_and_kind_of_curve_has_a_name_in_the_figure_or_its_legend(
    make: Callable[[], Chart],
) -> None:
    drawn = make()
    figure = picture(drawn).figure
    (axes,) = figure.axes
    filled = {to_hex(patch.get_facecolor()) for patch in axes.patches}
    listed = {to_hex(handle.get_markerfacecolor()) for handle in figure.artists if handle.get_marker() == "s"}
    assert len(filled) == len({color for _, color in colored(drawn) if color})
    texts, said = [text.get_text() for text in axes.texts], Words("chart")
    named = naming(drawn)
    shown = {
        to_hex(color or "#ffffff")
        for own, color in colored(drawn)
        if {named.short(own.kinds), *([said("nothing")] if own.kinds == () else [])} & set(texts)
    }
    assert listed | shown == {to_hex(color or "#ffffff") for _, color in colored(drawn)}
    assert not listed & shown

    def look(line: Any) -> tuple[Any, ...]:
        return line.get_color(), line.get_linestyle(), line.get_linewidth()

    curves = {look(line) for line in axes.lines if line.get_linestyle() != "None" and line.get_zorder() < 3}
    listed_curves = {look(handle) for handle in figure.artists if handle.get_linestyle() != "None"}
    told = {
        look(Line2D([], [], **(LOCI[locus.event][1] | EDGE)))
        for locus in drawn.loci
        if any(text == f"{locus.event.words} of {locus.word}" for text in texts)
    }
    assert listed_curves | told == curves
    assert not listed_curves & told


@pytest.mark.parametrize("make", EACH)
def test_fills_are_where_their_regions_are(make: Callable[[], Chart]) -> None:
    drawn, rng = make(), np.random.default_rng(5)
    (axes,) = picture(drawn).figure.axes
    color_of = {own.kinds: color for own, color in colored(drawn)}
    for at in drawn.plane.low + drawn.plane.widths * rng.uniform(0.0, 1.0, (120, 2)):
        region = drawn.regions.at(at.tolist()) if drawn.regions is not None else None
        if region is None or not clear(drawn, at):
            continue
        over = [to_hex(patch.get_facecolor()) for patch in axes.patches if patch.get_path().contains_point(at)]
        color = color_of[region.kinds]
        assert over == ([color.lower()] if color else []), at


@pytest.mark.parametrize("make", EACH)
def test_a_curve_in_chart_json_is_reproduced_by_the_printed_maps(make: Callable[[], Chart]) -> None:
    """With the impacts of its start, the device with its values and its condition, to 1e-9."""
    drawn = make()
    plane, data = drawn.plane, json.loads(data_of(drawn)["chart.json"])
    assert len(convert(data, ChartData).loci) == len(drawn.loci) > 0
    for locus in data["loci"]:
        start, condition = locus["start"], locus["condition"]
        word = Word.of(start["impacts"], start["periods"])
        device = plane.device_at(start["values"])
        kept = [i for i in range(len(word)) if i not in condition["touches"]]
        assert [start["velocity"][i] for i in condition["touches"]] == pytest.approx(
            [0] * len(condition["touches"]), abs=1e-9
        )
        assert condition["membranes"] == [
            "bottom" if start["impacts"][i] == "B" else "top" for i in condition["touches"]
        ]
        assert Word.of("".join(start["impacts"][i] for i in kept)).canonical().letters == locus["word"]
        np.testing.assert_allclose(np.mod(np.pi * np.array(start["time"]), 2 * np.pi), start["phase_rad"])
        groups = plane.at(start["values"])
        assert start["d"] == pytest.approx(groups.d)
        if not np.isscalar(device.restitution):
            continue  # the printed maps are of one restitution
        with mp.workdps(100):
            x, r = list(map(mpf, (*start["velocity"], *start["time"]))), mpf(float(device.restitution))
            d, gbar = mpf(float(groups.d)), mpf(float(groups.gbar))
            assert max(map(abs, printed_maps(word, x, d, gbar, r))) < 1e-9
            if condition["trace"] is not None:
                own = [x[i] for i in (*kept, *(len(word) + i for i in kept))]
                root = r ** len(kept)
                level = {"-(1 + D)": -1 - root**2, "1 + D": 1 + root**2, "2 sqrt(D)": 2 * root, "-2 sqrt(D)": -2 * root}
                trace = printed_trace(word, own, d, gbar, r) if not condition["touches"] else None
                assert trace is not None
                assert abs(trace - level[condition["trace"]]) < 1e-7 * max(1, abs(trace))
        sides = len(locus["values"]) - 1
        assert len(locus["parts_regions"]) == len(locus["bounds_stability"]) == sides
        assert not any(
            part and not ends for part, ends in zip(locus["parts_regions"], locus["bounds_stability"], strict=True)
        )
    assert len(data["regions"]) == len(drawn.regions.every if drawn.regions else ())


@cache
def data_of(drawn: Chart, *formats: Task) -> dict[str, bytes]:
    return outputs.files(drawn, scenario("inclined"), MapOutput(formats or (Task.JSON,)))


def report_opening(drawn: Chart) -> WordedOpening:
    return chart_opening(drawn, naming(drawn)).worded()


def test_a_chart_opens_in_few_words_with_the_ends_along_its_axes_in_the_digits_of_a_run() -> None:
    drawn = charted("inclined", SMALL)
    worded = report_opening(drawn)
    said = " ".join([*worded.text, worded.sentence])
    assert len(worded.facts) <= 4
    assert len(said.split()) <= 120
    for k, varied in enumerate(drawn.plane.inputs):
        end = drawn.design.nearest(k)
        shown = varied.show(end.value, exactness_of(drawn.design))
        assert any(
            f"In {varied.quantity} BT is stable {'up' if end.distance > 0 else 'down'} to {shown} (" in text
            for _, text in worded.facts
        )
        assert len(shown.split()[0].replace("°", "").replace(".", "").lstrip("0")) <= 4


@pytest.mark.slow
def test_a_chart_says_of_its_design_point_what_a_run_says(capsys) -> None:
    over = "length_m=0.65..0.75,inclination_deg=40..50"
    limits = ["--set", "motions={impacts: 2, periods: 1}"]
    assert main(["chart", str(EXAMPLES / "inclined.yaml"), "--over", over, *limits, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["alerts"]
    run = analyse(load(EXAMPLES / "inclined.yaml", ["sweep="]))
    assert told == [alert.to_dict() for alert in run.alerts]
    drawn = chart_of(load(EXAMPLES / "inclined.yaml", ["motions={impacts: 2, periods: 1}"]), over, lambda what: None)
    said = " ".join(outputs.text(drawn, tables=True).split())
    assert outputs.text(drawn).splitlines() == report_opening(drawn).lines
    assert len(report_opening(drawn).lines) == 3
    assert run.opening.worded().sentence in said
    assert len(run.opening.worded().sentence.split()) <= 15
    assert [x.value for x in report_opening(drawn).tiles] == [x.value for x in run.opening.worded().tiles]
    assert all(f"{alert.code} {alert.title}" in said for alert in run.alerts)
    report = outputs.report_of(drawn, load(EXAMPLES / "inclined.yaml"), MapOutput())
    assert (report.verdict.status, report.verdict.word) == (run.verdict.status, run.opening.worded().word)


@pytest.mark.parametrize(
    ("file", "source", "place"),
    [
        ("sections/regions.typ.j2", "{{ report.nothing }}", "sections/regions.typ.j2:1: "),
        ("words/chart.j2", "{% macro title() %}\n{{ x.nothing }}{% endmacro %}", "words/chart.j2"),
    ],
)
def test_a_wrong_name_in_a_template_is_told_with_its_place(file: str, source: str, place: str, tmp_path: Path) -> None:
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text(source, encoding="utf-8")
    with pytest.raises(RenderError, match=place):
        outputs.files(charted("inclined", SMALL), scenario("inclined"), MapOutput((Task.HTML,), templates=tmp_path))


def test_the_report_of_a_chart_says_what_is_kept_and_its_first_page_is_short() -> None:
    drawn = charted("inclined", SMALL)
    page = Page(data_of(drawn, Task.HTML)["report.html"])
    assert read_back("chart", lines_of(page.data)) == []
    assert read_back("chart, terminal", outputs.text(drawn, tables=True).splitlines()) == []
    shares = page.tables["What is stable, and where that was solved for"].columns("Part of the chart", "Regions")
    assert [float(share.removesuffix(" %")) for share, _ in shares] == sorted(
        (pytest.approx(100 * own.share, rel=0.06) for own in drawn.regions.sets), key=lambda own: -own.expected
    )
    text = tidy(page.text)
    first = text[text.index(page.headings[0]) : text.index("Where BT ends")]
    assert len(first.split()) <= 150
    assert len(re.findall(r"\d+(?:[.:]\d+)?", first)) <= 25 + 20  # with the ticks of the figure


@pytest.mark.slow
@pytest.mark.parametrize(("name", "make"), {"all words": all_words, "both restitutions": CHARTS[3]}.items())
def test_the_reports_of_other_charts_say_what_is_kept(name: str, make: Callable[[], Chart]) -> None:
    """Beyond that of a small one, and without numbers, which come from the chart."""
    known = set(map(without_numbers, kept_lines("chart")))
    said = map(without_numbers, lines_of(data_of(make(), Task.HTML)["report.html"]))
    assert read_back(f"chart, {name}", [line for line in said if line not in known]) == []
