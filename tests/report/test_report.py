"""The report: both outputs say the same, and no text of a scenario is markup; `test_shown.py` holds its numbers."""

from __future__ import annotations

import json
import re
from functools import partial
from io import BytesIO
from math import pi, radians, sin
from pathlib import Path
from tempfile import gettempdir
from types import SimpleNamespace
from typing import Any

import pytest
import typst
from conftest import first
from msgspec.structs import replace
from pages import Page, render_html, render_pdf, squeeze, tidy
from pypdf import PdfReader

from vireport.base.errors import RenderError, UsageError
from vireport.figures.layout import blank
from vireport.figures.style import Picture
from vireport.report.context import Report
from vireport.report.tables import RunTables
from vireport.scenario.loading import load, loads
from vireport.study.provenance import provenance_of, with_pages
from vireport.study.study import Study, analyse
from vireport.text.folders import TEMPLATES
from vireport.text.formatting import MINUS

ROOT = TEMPLATES.parent
NAMES = first(1, ("inclined", "design-point", "horizontal", "inclined-forcing"))
HOSTILE = (
    """A&B <script>alert(1)</script> #$_*@\\ " ' ` #panic("x") {{ 1 }} *d* x_c ]]) */ // \u05d0\u05d1 $x$ </title> """
    + "w" * 90
)


PICTURES = tuple(
    Picture(f"figure-{k}", f"Title {k}", f"Caption {k}.", f"Words for {k}", blank(panels)[0])
    for k, panels in ((2, 3), (4, 2), (7, 1))
)


def model_of(study: Study, pictures: tuple[Picture, ...] = PICTURES) -> Report:
    origin = with_pages(provenance_of(study.loaded, "vireport run test.yaml"), drawn=bool(pictures))
    return Report(study, {picture.name: picture for picture in pictures}, origin)


@pytest.fixture(scope="module")
def model(study_of):
    models: dict[str, Report] = {}
    return lambda name: models.setdefault(name, model_of(study_of(name), PICTURES if name != "design-point" else ()))


@pytest.fixture(scope="module")
def page(model):
    pages: dict[str, Page] = {}
    return lambda name: pages.setdefault(name, Page(render_html(model(name))))


@pytest.fixture(scope="module")
def reader(model):
    readers: dict[str, tuple[PdfReader, str]] = {}

    def read(name: str) -> tuple[PdfReader, str]:
        if name not in readers:
            pdf = PdfReader(BytesIO(render_pdf(model(name))))
            readers[name] = pdf, squeeze("".join(sheet.extract_text() for sheet in pdf.pages))
        return readers[name]

    return read


@pytest.mark.parametrize("name", NAMES)
def test_both_outputs_have_the_same_sections(name: str, page, reader) -> None:
    swept = name != "design-point"
    margin = {
        "horizontal": "the margin with soft membranes is not known",
        "inclined-forcing": "no margin is left to use",
    }.get(name, "the margin is small")
    titles = [f"It runs, and starts by itself; {margin}.", "Margins", "Alerts"]
    titles += [*(["The paper’s figures"] if swept else []), "Inputs", "Appendix"]
    assert page(name).headings == titles
    outline = [item.title for item in reader(name)[0].outline if not isinstance(item, list)]
    assert outline == titles[1:]
    anchors = [*("margins", "alerts"), *(["paper-figures"] if swept else []), "scenario", "appendix"]
    links = [link.lstrip("#") for link in page(name).attributes("href")]
    assert links[1 : 1 + len(anchors)] == anchors


@pytest.mark.parametrize("name", NAMES)
def test_both_outputs_have_every_number(name: str, page, reader) -> None:
    cells = {squeeze(cell) for table in page(name).all_tables for row in table.rows for cell in row}
    # In a PDF the text of cells that wrap may be in another order; numbers do not wrap.
    numbers = {cell for cell in cells if re.fullmatch(rf"[{MINUS}+]?[\d.]+(×10\S+|%)?", cell)}
    assert len(numbers) > 60
    assert not {cell for cell in numbers if cell not in reader(name)[1]}


@pytest.mark.parametrize("name", NAMES)
def test_every_row_of_a_table_is_whole(name: str, page) -> None:
    for table in page(name).all_tables:
        assert table.caption
        assert all(len(row) == len(table.rows[0]) for row in table.rows)


@pytest.mark.parametrize("name", NAMES)
def test_no_line_can_end_within_a_quantity(name: str, page) -> None:
    prose = "".join(part for part in page(name).parts if "#" not in part and "{" not in part)  # no code, no data
    assert re.search(r"\d\u00a0Hz", prose)
    assert not re.findall(r".{20}(?:= [\d−]|\d (?:%|×|[nµmkMG]?(?:m|V|N|g|Hz|s|W|J|rad)\b)).{9}", prose)


def test_the_points_are_said_to_be_as_exact_as_the_least_exact_of_them() -> None:
    points = [SimpleNamespace(error_bound=bound) for bound in (1e-16, 3e-16, 2e-16)]
    study = SimpleNamespace(solution=SimpleNamespace(critical_points=points))
    assert RunTables(study).largest_bound == 3e-16


@pytest.mark.parametrize("name", NAMES)
def test_the_first_page_has_the_answer_in_few_words_and_numbers(name: str, page, study_of, reader) -> None:
    opening = study_of(name).opening.worded()
    text = page(name).text
    first = text[text.index(opening.sentence) : text.index("How far each input can go")]
    sheet, second, *_ = (squeeze(page.extract_text()) for page in reader(name)[0].pages)
    assert squeeze("How far each input can go") not in sheet
    assert squeeze("How far each input can go") in second
    for says in (*opening.text[:1], *(told for _, told in opening.facts)):
        assert tidy(says) in tidy(first)
        assert squeeze(says) in sheet
    for tile in opening.tiles:
        assert tidy(f"{tile.label}{tile.value}{tile.remark}") in tidy(first) or tidy(tile.value) in tidy(first)
        assert squeeze(tile.value) in sheet
    words, numbers = first.split(), re.findall(r"\d+(?:[.:]\d+)?", first)
    assert len(words) <= 150
    assert len(numbers) <= 25


def test_every_picture_stands_once_and_the_papers_have_its_numbers(page, model) -> None:
    html = render_html(model("inclined")).decode()
    numbered = [picture.name.removeprefix("figure-") for picture in PICTURES if picture.name[-1].isdigit()]
    for number in numbered:
        assert html.count(f'id="figure-{number}"') == 1
    assert re.findall(r"Figure (\d+)\. [A-Z]", page("inclined").text) == numbered


def test_units_and_groups_are_those_of_2_5_and_2_6(model) -> None:
    solution = model("inclined").solution
    device, omega = solution.device, 2 * pi * solution.device.frequency_hz
    acceleration = device.amplitude_n / device.capsule_mass_kg
    units = (acceleration * pi**2 / omega**2, acceleration * pi / omega, pi / omega)
    gbar = device.gravity_m_s2 * sin(radians(device.inclination_deg)) / acceleration
    lengths = (device.length_m, solution.sweep.start, solution.sweep.end)
    for column, length in zip(model("inclined").derived(), lengths, strict=True):
        assert (column["x_c"], column["y_c"], column["t_c"]) == pytest.approx(units, rel=1e-14)
        assert (column["d"], column["gbar"]) == pytest.approx((length / units[0], gbar), rel=1e-14)


def test_the_verdict_carries_the_answer(study_of) -> None:
    opening = study_of("inclined").opening.worded()
    assert (opening.status, opening.word) == ("caution", "Stable, margin small")
    assert [tidy(line) for line in opening.text] == [
        "It runs, and starts by itself; the margin is small.",
        "Increase the frequency for more margin, or measure the restitution at the bottom.",
        "The ball strikes each membrane once per period.",
        "The ball presses the membranes 19 mm deep and stretches them to 5.3 times their area: state the thickness to "
        "check field and energy.",
        "Stable length: above 0.629 m (up to 0.75 m, the end of the sweep)",
        "Margin to use: 1.0 % in frequency (with a bottom membrane that rebounds 5 % less)",
        "From rest: 23 periods (12 s; a simulation agrees)",
        "Mean voltage: 42.8 kV (by the paper’s formulae, extrapolated)",
    ]
    assert len(opening.lines) == 3
    gone = study_of("inclined-forcing").opening.worded()
    assert (gone.status, gone.sentence) == ("caution", "It runs, and starts by itself; no margin is left to use.")


@pytest.mark.parametrize("name", NAMES)
def test_the_margin_to_use_is_the_least_of_all(name: str, study_of) -> None:
    results = study_of(name).to_dict()
    margins = results["design_point"]["margins"]
    known = (m for m in margins if (m["ends_stability"] or m["taken_over"]) and m["percent"] is not None)
    end = min(known, key=lambda m: abs(m["percent"]))
    own = results["own_stiffness"]["ends"]
    soft = [
        e["compliant_margin"] for e in own if e["parameter"] == end["parameter"] and e["compliant_margin"] is not None
    ]
    left = [row["margin_left"] for row in results["effects"]["rows"] if row["margin_left"] is not None]
    use = results["margin_to_use"]
    least = min([abs(end["percent"]) / 100, *soft, *left])
    assert use["relative"] == pytest.approx(least, rel=1e-9)
    assert use["limited_by"] == ("effect" if least in left else "compliant" if least in soft else "rigid")


@pytest.mark.parametrize(
    ("overrides", "status", "says"),
    [
        (["device.length_m=0.6"], "bad", "Move the length into a stable range."),
        (["device.length_m="], "good", "Stable length: above 0.629 m"),
        (["device.length_m=", "device.ball_mass_kg=1e-9"], "good", "It runs for 0.6295 m < s ≤ 0.75 m."),
        (["device.length_m=0.8"], "good", "Margin to use: 7.8 % in frequency (with a bottom membrane"),
        (["sweep.to=0.62", "device.length_m="], "bad", "It does not run: no 1:1 motion is stable."),
        (["device.ball_mass_kg="], "caution", "Mean voltage: not evaluated (needs device.ball_mass_kg)"),
        (
            ["device.ball_mass_kg=1e-9", "device.length_m=0.9", "sweep.to=0.9"],
            "good",
            "It runs, and starts by itself, with",
        ),
    ],
)
def test_verdicts(overrides: list[str], status: str, says: str, example) -> None:
    opening = analyse(load(example("inclined"), overrides)).opening.worded()
    assert opening.status == status
    assert says in tidy("\n".join(opening.text))


def test_without_the_ball_mass_there_is_no_energy(example) -> None:
    page = Page(render_html(model_of(analyse(load(example("inclined"), ["device.ball_mass_kg="])), ())))
    assert "Voltage" not in page.headings
    assert "Symbols: motion" in page.tables
    assert "(4.2)" in page.text
    assert "(5.1)" not in page.text
    assert "Give device.ball_mass_kg for voltages and long contacts." in tidy(page.text)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_said_what_to_add_for_more(name: str, page, study_of) -> None:
    for line in study_of(name).plan.left_out_lines():
        assert line in tidy(page(name).text)
    ids = page(name).attributes("id")
    assert [x for x in ids if x.startswith("VR")] == [alert.code for alert in study_of(name).alerts]


def hostile_study(example) -> Study:
    text = example("inclined").read_text(encoding="utf-8")
    text = re.sub(r"^title:.*$", lambda _: f"title: {json.dumps(HOSTILE)}", text, flags=re.MULTILINE)
    return analyse(loads(f"# {HOSTILE}\n{text}\n# \u202e{'w' * 5000}\n", "a<b>&\"'#[x].yaml"))


def scripts(page: Page) -> list[str | None]:
    """The types of a page's scripts: scenario and results, as data, and none that runs."""
    return [attributes.get("type") for tag, attributes in page.tags if tag == "script"]


@pytest.mark.slow
def test_free_text_is_text(example) -> None:
    model = model_of(hostile_study(example))
    page = Page(render_html(model))
    assert page.text.count(tidy(HOSTILE)) == 2  # the title, the comment in the listing
    assert scripts(page) == ["application/json"] * 2
    assert all(not name.startswith("on") for _, attributes in page.tags for name in attributes)
    pdf = PdfReader(BytesIO(render_pdf(model)))
    text = squeeze("".join(sheet.extract_text() for sheet in pdf.pages))
    assert pdf.metadata is not None
    assert pdf.metadata.title == model.heading
    assert text.count(squeeze(HOSTILE[:60])) == 2  # under the heading, and in the listing
    assert squeeze("a<b>&\"'#[x].yaml") in text
    (attached,) = pdf.attachments["scenario.yaml"]
    assert attached.decode() == model.listing


@pytest.mark.slow
def test_nothing_of_the_machine_in_the_report(model) -> None:
    html, pdf = render_html(model("inclined")), render_pdf(model("inclined"))
    for data in (html, pdf):
        for trace in (str(ROOT), gettempdir()):
            assert trace.encode() not in data
    assert PdfReader(BytesIO(pdf)).metadata.creation_date is None


@pytest.mark.slow
def test_source_date_epoch_is_the_only_clock(study_of, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    model = model_of(study_of("design-point"), ())
    assert model.provenance.timestamp == "2023-11-14T22:13:20+00:00"
    assert b"2023-11-14T22:13:20+00:00" in render_html(model)
    date = PdfReader(BytesIO(render_pdf(model))).metadata.creation_date
    assert date is not None
    assert date.timestamp() == 1700000000
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "today")
    with pytest.raises(UsageError, match="SOURCE_DATE_EPOCH"):
        provenance_of(study_of("design-point").loaded, "x")


def test_the_page_needs_nothing_else(page) -> None:
    report = page("inclined")
    assert all(url.startswith(("#", "data:")) for name in ("href", "src") for url in report.attributes(name))
    tags = {tag for tag, _ in report.tags}
    assert not tags & {"iframe", "object", "embed", "form"}
    assert scripts(report) == ["application/json"] * 2
    policy = next(a["content"] for t, a in report.tags if t == "meta" and a.get("http-equiv"))
    assert policy is not None
    assert policy.startswith("default-src 'none';")
    for template in TEMPLATES.glob("*.j2"):
        assert "@preview" not in template.read_text(encoding="utf-8")
    assert "url(" not in (TEMPLATES / "_style.css").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_accessible(name: str, page) -> None:
    report = page(name)
    assert dict(report.tags)["html"]["lang"] == "en"
    ids = report.attributes("id")
    assert len(ids) == len(set(ids))
    references = [url[1:] for url in report.attributes("href") if url.startswith("#")]
    references += report.attributes("aria-labelledby")
    assert set(references) <= set(ids)
    for tag, attributes in report.tags:
        if tag == "img":
            assert attributes["alt"]
        if tag == "th":
            assert attributes["scope"] in ("col", "row")
        if attributes.get("role") == "math":
            assert attributes["aria-label"]
    tags = [tag for tag, _ in report.tags]
    assert tags.count("h1") == tags.count("main") == 1
    assert tags.count("math") == report.attributes("role").count("math") > 20


@pytest.mark.parametrize("name", NAMES)
def test_pdf_ua_1(name: str, model, monkeypatch) -> None:
    """Typst refuses what does not conform to it, where it is told to."""
    real = typst.Compiler

    def strict(**given: Any) -> SimpleNamespace:
        return SimpleNamespace(compile=partial(real(**given).compile, pdf_standards=["ua-1"]))

    monkeypatch.setattr(typst, "Compiler", strict)
    reader = PdfReader(BytesIO(render_pdf(model(name))))
    assert reader.trailer["/Root"]["/MarkInfo"]["/Marked"]
    assert reader.trailer["/Root"]["/Lang"] == "en"


@pytest.mark.slow
def test_pages_are_numbered(reader) -> None:
    pages = reader("inclined")[0].pages
    for i, sheet in enumerate(pages, 1):
        assert f"Page {i} of {len(pages)}" in tidy(sheet.extract_text())


@pytest.mark.slow
def test_a_real_report_is_small(study_of) -> None:
    from vireport.figures.pictures import pictures

    study = study_of("horizontal")
    html = render_html(model_of(study, pictures(study)))
    assert len(html) < 500_000
    assert html.count(b"<svg ") == 6


def test_a_users_templates_win_file_by_file(model, tmp_path: Path) -> None:
    (tmp_path / "_style.css").write_text("body { color: rebeccapurple }")
    html = render_html(replace(model("design-point"), templates=tmp_path))
    assert b"rebeccapurple" in html
    assert b"--good-back" not in html
    assert b"<h2" in html
    assert b"rebeccapurple" not in render_html(model("design-point"))


def test_a_user_rewords_reorders_drops_and_adds_sections(model, tmp_path: Path) -> None:
    sections = tmp_path / "sections"
    sections.mkdir()
    (sections / "alerts.typ.j2").write_text("= Mind this\n{{ report.study.alerts | length }} alerts.\n")
    (sections / "own.typ.j2").write_text("= Our part\nLength: {{ report.solution.device.length_m | quantity('m') }}\n")
    names = ("own", "alerts", "scenario")
    master = [f'{{% include "sections/{name}.typ.j2" %}}' for name in names]
    head = ['{% import "_macros.typ.j2" as macros %}', '{% include "_page.typ.j2" %}']
    (tmp_path / "report.typ.j2").write_text("\n".join([*head, *master]))
    page = Page(render_html(replace(model("design-point"), templates=tmp_path)))
    assert page.headings == ["Our part", "Mind this", "Inputs"]
    assert "Length: 700 mm" in page.text
    pdf = PdfReader(BytesIO(render_pdf(replace(model("design-point"), templates=tmp_path))))
    assert "Our part Length: 700 mm Mind this 3 alerts." in tidy(pdf.pages[0].extract_text())


def test_text_is_inert_wherever_a_template_has_it(example, tmp_path: Path) -> None:
    title = 'x" + panic("a") + " */ #panic("b") {{ 1 / 0 }} [$'
    study = analyse(load(example("design-point"), {"title": title}))
    (tmp_path / "report.typ.j2").write_text(
        "// {{ report.title }}\n/* {{ report.title }} */ #let x = {{ report.title | string }}\n"
        "= {{ report.title }}\n*{{ report.title }}* $ {{ report.title }} $ #x"
    )
    assert Page(render_html(replace(model_of(study, ()), templates=tmp_path))).text.count(title) == 4


@pytest.mark.parametrize("render", [render_html, render_pdf])
def test_a_mistake_in_typst_is_shown_without_our_folders(render, model, tmp_path: Path) -> None:
    (tmp_path / "report.typ.j2").write_text("= Head\n\n#nonsense(1)\n" + "x" * 400)
    with pytest.raises(RenderError, match="unknown variable: nonsense") as caught:
        render(replace(model("design-point"), templates=tmp_path))
    message = str(caught.value)
    assert "report.typ.j2:3" in message
    assert "/tmp" not in message
    assert "development" not in message
    assert max(map(len, message.splitlines())) <= 160


def test_a_missing_folder_of_templates(model, tmp_path: Path) -> None:
    for render in (render_html, render_pdf):
        with pytest.raises(UsageError, match="no such folder of templates"):
            render(replace(model("design-point"), templates=tmp_path / "nowhere"))


@pytest.mark.slow
def test_a_long_scenario_is_attached_and_not_printed(example) -> None:
    text = example("design-point").read_text(encoding="utf-8") + "# filler\n" * 2000
    model = model_of(analyse(loads(text, "long.yaml")), ())
    assert render_html(model).count(b"filler") == 2000  # in what the page carries alone
    pdf = PdfReader(BytesIO(render_pdf(model)))
    assert pdf.attachments["scenario.yaml"][0].decode() == text
    assert len(pdf.pages) < 8


def test_equations_have_roots_fractions_bars_and_accents_above_their_letters(model, page, reader) -> None:
    html = render_html(model("inclined")).decode()
    maths = "".join(re.findall(r"<math.*?</math>", html, re.DOTALL))
    for tag in ("msqrt", "mfrac", "mover", "mtable", "msubsup"):
        assert f"<{tag}" in maths
    assert maths.count("<msqrt") == 2
    assert not set(maths) & {"\u0304", "\u0307", "\u0308"}
    assert {"˙", "¯", "¨"} <= set(maths)
    numbers = set(re.findall(r"\((?:[2345]\.\d+|A\.\d)(?:, (?:\d\.\d+|A\.\d))?\)", page("inclined").text))
    assert len(numbers) > 15
    assert all(squeeze(number) in reader("inclined")[1] for number in numbers)


@pytest.mark.slow
def test_provenance_is_enough_to_repeat(model, page) -> None:
    provenance = model("inclined").provenance
    for text in (
        provenance.version,
        provenance.scenario_sha256,
        provenance.python,
        provenance.command,
        *(f"{n} {v}" for n, v in provenance.libraries.items()),
    ):
        assert text in page("inclined").text
    assert {*provenance.libraries} == {
        "jinja2",
        "matplotlib",
        "numpy",
        "pydantic_core",
        "typst",
        "yaml",
    }
    assert replace(provenance, timestamp=None).epoch == 0


def test_the_margin_names_the_pitchfork_on_the_way(study_of):
    """A symmetric motion gives way to asymmetric ones before the stable range ends."""
    nearest = study_of("horizontal").verdict.margin.data
    assert (nearest.end.label, nearest.end.taken_over, nearest.lost.label) == ("C1", True, "B1")
    assert round(nearest.lost.relative, 2) == -0.29
    assert not study_of("inclined").verdict.margin.data.end.taken_over
