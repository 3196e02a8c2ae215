"""The report: both outputs say the same, the numbers are the results', no text of a scenario is markup."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from tempfile import gettempdir

import pytest
from pypdf import PdfReader

from vireport.errors import UsageError
from vireport.figures import Picture, blank
from vireport.gate.verdict import Question
from vireport.report.build import build_report
from vireport.report.equations import ENERGY, GROUPS
from vireport.report.pages import Equation, Listing, ReportModel, Table
from vireport.report.rendering import TEMPLATES, RenderError, pieces, render_html, render_pdf
from vireport.scenario.loading import load, loads
from vireport.study.provenance import provenance_of
from vireport.study.study import Study, analyse
from vireport.text.formatting import MINUS, words

ROOT = TEMPLATES.parent
NAMES = ("horizontal", "inclined", "inclined-forcing", "design-point")
HOSTILE = """A&B <script>alert(1)</script> #$_*@\\ " ' ` #panic("x") {{ 1 }} *d* x_c ]])"""


PICTURES = tuple(
    Picture(f"figure-{k}", f"Title {k}", f"Caption {k}.", f"Words for {k}", blank(panels)[0])
    for k, panels in ((2, 3), (4, 2), (7, 1))
)


def model_of(study: Study, pictures: tuple[Picture, ...] = PICTURES) -> ReportModel:
    return build_report(study, pictures, provenance_of(study.loaded, "vireport run test.yaml"))


class Page(HTMLParser):
    """Text, headings and attributes of an HTML page."""

    def __init__(self, data: bytes) -> None:
        super().__init__(convert_charrefs=True)
        self.parts: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.headings: list[str] = []
        self.open: list[str] = []
        self.feed(data.decode("utf-8"))
        self.text = tidy("".join(self.parts))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.parts.append("" if tag in ("i", "sub", "b", "strong", "code", "a", "span") else " ")
        if tag not in ("meta", "link", "img", "br", "path", "circle"):
            self.open.append(tag)
        if tag == "h2":
            self.headings.append("")

    def handle_endtag(self, tag: str) -> None:
        while self.open and self.open.pop() != tag:
            pass
        self.parts.append("" if tag in ("i", "sub", "b", "strong", "code", "a", "span") else " ")

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.parts.append(data)
        if "h2" in self.open:
            self.headings[-1] += data.strip()

    def attributes(self, name: str) -> list[str]:
        return [attributes[name] or "" for _, attributes in self.tags if name in attributes]


def tidy(text: str) -> str:
    return " ".join(text.replace("\u00a0", " ").split())


def plain(text: str) -> str:
    """What is left of a text of the report when it is set."""
    return tidy("".join(part for _, part in pieces(text)))


def squeeze(text: str) -> str:
    """Without spaces, which a PDF's text has where its lines break."""
    return re.sub(r"\s", "", text.replace("\u00ad", ""))


@pytest.fixture(scope="module")
def model(study_of):
    models: dict[str, ReportModel] = {}
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


def cells(model: ReportModel) -> list[str]:
    """Every printed cell and verdict answer."""
    tables = [block for section in model.sections for block in section.blocks if isinstance(block, Table)]
    found = [
        cell if table.columns[i].kind != "text" else plain(cell)
        for table in tables
        for row in table.rows
        for i, cell in enumerate(row)
    ]
    return found + [plain(text) for fact in model.verdict.facts for text in (fact.answer, fact.detail)]


@pytest.mark.parametrize("name", NAMES)
def test_both_outputs_have_the_same_sections(name: str, model, page, reader) -> None:
    titles = ["Verdict", *(section.title for section in model(name).sections)]
    assert page(name).headings == titles
    outline = [item.title for item in reader(name)[0].outline if not isinstance(item, list)]
    assert outline == titles
    keys = [section.key for section in model(name).sections]
    expected = [
        "alerts",
        "scenario",
        "table-1",
        "critical-points",
        "design-point",
        "figures",
        "energy",
        "equations",
        "paper",
    ]
    if name == "design-point":
        expected = ["alerts", "scenario", "design-point", "energy", "equations"]
    assert keys == [*expected, "left-out", "provenance"]


@pytest.mark.parametrize("name", NAMES)
def test_both_outputs_have_every_number(name: str, model, page, reader) -> None:
    html, pdf = squeeze(page(name).text), reader(name)[1]
    found = {squeeze(cell) for cell in cells(model(name)) if cell}
    assert len(found) > 80
    assert not {cell for cell in found if cell not in html}
    # In a PDF the text of cells that wrap may be in another order; numbers do not wrap.
    numbers = {cell for cell in found if re.fullmatch(rf"[{MINUS}+]?[\d.]+(×10\S+|%)?", cell)}
    assert len(numbers) > 30
    assert not {cell for cell in numbers if cell not in pdf}
    assert squeeze(plain(model(name).verdict.headline)) in pdf
    assert squeeze(plain(model(name).verdict.headline)) in html


def number(text: str) -> float:
    exponent = {ord(a): b for a, b in zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True)}
    mantissa, _, power = text.replace(MINUS, "-").removesuffix(" %").partition(" × 10")
    return float(f"{mantissa}e{power.translate(exponent) or 0}" if power else mantissa)


def column(model: ReportModel, section: str, caption: str, *titles: str) -> list[tuple[str, ...]]:
    """Columns of a table by their titles; a title that stands twice is told apart by a trailing number."""
    (found,) = [s for s in model.sections if s.key == section]
    (table,) = [b for b in found.blocks if isinstance(b, Table) and b.caption == caption]
    names: list[str] = []
    for each in table.columns:
        names.append(f"{each.title} 2" if each.title in names else each.title)
    return [tuple(row[names.index(title)] for title in titles) for row in table.rows]


@pytest.mark.parametrize("name", NAMES[:3])
def test_table_1_is_the_results(name: str, model, study_of) -> None:
    study = study_of(name)
    swept = "*F* [N]" if name == "inclined-forcing" else "*s* [m]"
    rows = column(
        model(name),
        "table-1",
        "Table 1 for this scenario",
        "Motion",
        "*d* from",
        "to",
        f"{swept} from",
        "to 2",
        "Type",
    )
    assert len(rows) == len(study.solution.table)
    for printed, row in zip(rows, study.solution.table, strict=True):
        assert (printed[0].lower(), printed[5]) == (row.family, row.stability)
        values = (row.d_start, row.d_end, row.sweep_start, row.sweep_end)
        assert [number(text) for text in printed[1:5]] == pytest.approx(values, rel=6e-8)


@pytest.mark.parametrize("name", NAMES[:3])
def test_critical_points_are_the_results(name: str, model, study_of) -> None:
    points = study_of(name).solution.critical_points
    swept = "*F* [N]" if name == "inclined-forcing" else "*s* [m]"
    rows = column(model(name), "critical-points", "Critical points: where", "Point", swept, "± bound", "*d*")
    for (label, value, bound, d), point in zip(rows, points, strict=True):
        assert label == point.label
        assert number(value) == pytest.approx(point.point.sweep_value, rel=6e-12)
        assert len(value.replace(".", "").lstrip("0")) == 12
        assert point.point.error_bound <= number(bound) <= 1.1 * point.point.error_bound
        assert number(d) == pytest.approx(point.point.d, rel=6e-12)
    rows = column(
        model(name),
        "critical-points",
        "Critical points: the motion there",
        "Point",
        "*q*",
        "*φ*_B",
        "*φ*_T",
        "*Ż*_T",
    )
    mirrored = [(p, twin) for p in points for twin in (False, True) if not twin or p.mirror is not None]
    for (label, *texts), (point, twin) in zip(rows, mirrored, strict=True):
        motion = point.mirror if twin else point.point
        top = (point.point.phi + 3.141592653589793) % 6.283185307179586 if twin else point.phi_top
        assert label == point.label
        values = (0.5 + motion.u, motion.phi, top, motion.velocity_top)
        assert [number(text) for text in texts] == pytest.approx(values, rel=6e-8, abs=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_the_design_point_is_the_results(name: str, model, study_of) -> None:
    study = study_of(name)
    x = study.solution.design.motions
    rows = column(
        model(name),
        "design-point",
        "1:1 motions at the design point",
        "Type",
        "*q*",
        "*φ*_B",
        "*Ż*_B",
        "*Ż*_T",
        "Tr",
    )
    for i, (word, *texts) in enumerate(rows):
        values = (x.q[i], x.phi_bottom[i], x.velocity_bottom[i], x.velocity_top[i], x.trace[i])
        assert word == x.words[i]
        assert [number(text) for text in texts] == pytest.approx(values, rel=6e-6)
    ranges = column(
        model(name), "design-point", "Stable ranges around the design point, one input varied at a time",
        "From", "To", "room", "room 2",
    )  # fmt: skip
    for (start, end, below, above), part in zip(ranges, study.solution.design.stable, strict=True):
        at = getattr(study.solution.device, part.parameter)
        assert [number(start), number(end)] == pytest.approx([part.start, part.end], rel=6e-8)
        if at:
            room = [100 * (part.start - at) / at, 100 * (part.end - at) / at]
            assert [number(below), number(above)] == pytest.approx(room, rel=0.06)


@pytest.mark.parametrize("name", NAMES)
def test_voltages_are_the_results(name: str, model, study_of) -> None:
    study = study_of(name)
    stable = study.solution.design.motions.stable
    volts = study.solution.design.voltages
    rows = column(
        model(name),
        "energy",
        "Voltages of the stable motions",
        "Stable motion",
        "bottom [kV]",
        "*U*_ave [kV]",
        "*δ* [mm]",
    )
    first = [number(text) for text in rows[0][1:]]
    expected = (
        volts.bottom_v[stable][0] / 1e3,
        volts.average_v[stable][0] / 1e3,
        volts.deflection_m[stable][0] * 1e3,
    )
    assert first == pytest.approx(expected, rel=6e-4)
    if study.solution.sweep is not None:
        assert {row[0] for row in rows[1:]} >= {"End of the sweep", "B1, end of the stable range"}
    (blocks,) = [s.blocks for s in model(name).sections if s.key == "energy"]
    assert "*m* = 4.1 g is given by the scenario" in blocks[0].text
    (mass,) = [b for b in blocks if isinstance(b, Table) and "ball mass" in b.caption]
    averages = [number(row[4]) for row in mass.rows]
    assert [number(row[1]) for row in mass.rows] == pytest.approx([2.05, 4.1, 8.2, 24.9])
    assert averages[1] == pytest.approx(first[1], rel=1e-3)
    assert averages == sorted(averages)


def test_the_verdict_carries_the_answer(study_of) -> None:
    verdict = study_of("inclined").verdict
    assert verdict.status == "good"
    for says in (
        "0.629457 m < s ≤ 0.75 m",
        "stable node",
        "4.7 % in frequency",
        "period doubling B1",
        "42.84 kV",
        "outside",
    ):
        assert says in verdict.headline
    assert study_of("inclined-forcing").verdict.status == "caution"


@pytest.mark.parametrize(
    ("overrides", "status", "says"),
    [
        (["device.length_m=0.6"], "bad", "At the design point s = 0.6 m: no stable motion"),
        (["device.length_m="], "good", "0.629457 m < s ≤ 0.75 m"),
        (["device.length_m=0.8"], "good", "margin 11 % in frequency, to period doubling B1"),
        (["sweep.to=0.62", "device.length_m="], "bad", "No stable 1:1 motion in the sweep"),
        (["device.ball_mass_kg="], "good", "margin 4.7 % in frequency, to period doubling B1, local stability only."),
        (["device.ball_mass_kg=1e-9"], "good", "V."),
    ],
)
def test_verdicts(overrides: list[str], status: str, says: str, example) -> None:
    verdict = analyse(load(example("inclined"), overrides)).verdict
    assert verdict.status == status
    assert says in verdict.headline
    assert "outside the membrane model" not in verdict.headline or "V (" in verdict.headline


def test_without_the_ball_mass_there_is_no_energy(example) -> None:
    model = model_of(analyse(load(example("inclined"), ["device.ball_mass_kg="])), ())
    keys = [section.key for section in model.sections]
    assert "energy" not in keys
    equations = [b.name for s in model.sections for b in s.blocks if isinstance(b, Equation)]
    assert not set(equations) & set(ENERGY[2])
    assert set(equations) == {name for _, _, names in GROUPS for name in names}
    (left,) = [s for s in model.sections if s.key == "left-out"]
    assert ("Voltages", "device.ball_mass_kg is not given") in left.blocks[0].rows


@pytest.mark.parametrize("name", NAMES)
def test_everything_left_out_is_named(name: str, model, study_of) -> None:
    (left,) = [s for s in model(name).sections if s.key == "left-out"]
    found = {what.lower(): why.lower() for what, why in left.blocks[0].rows}
    for step in study_of(name).plan.left_out:
        assert found[words(step.what).lower()] == words(step.why).lower()
    (section,) = [s for s in model(name).sections if s.key == "alerts"]
    assert [block.code for block in section.blocks] == [alert.code for alert in study_of(name).alerts]


def hostile_study(example) -> Study:
    text = example("inclined").read_text(encoding="utf-8")
    text = re.sub(r"^title:.*$", lambda _: f"title: {json.dumps(HOSTILE)}", text, flags=re.MULTILINE)
    return analyse(loads(f"# {HOSTILE}\n{text}", "a<b>&\"'#[x].yaml"))


def scripts(page: Page) -> list[str | None]:
    """The types of a page's scripts: the data of the live figures, and what reads it."""
    return [attributes.get("type") for tag, attributes in page.tags if tag == "script"]


def test_free_text_is_text(example) -> None:
    model = model_of(hostile_study(example))
    page = Page(render_html(model))
    assert page.text.count(tidy(HOSTILE)) == 3  # the title, the heading, the comment in the listing
    assert scripts(page) == ["application/json", None]
    assert all(not name.startswith("on") for _, attributes in page.tags for name in attributes)
    pdf = PdfReader(BytesIO(render_pdf(model)))
    text = squeeze("".join(sheet.extract_text() for sheet in pdf.pages))
    assert pdf.metadata is not None
    assert pdf.metadata.title == HOSTILE
    # On top, in each running head, and in the listing.
    assert text.count(squeeze(HOSTILE)) >= len(pdf.pages) + 1
    assert squeeze("a<b>&\"'#[x].yaml") in text
    (attached,) = pdf.attachments["scenario.yaml"]
    assert attached.decode() == model.scenario_text


@pytest.mark.slow
def test_same_input_same_bytes(example, tmp_path: Path, model) -> None:
    here = [hashlib.sha256(part(model("inclined"))).hexdigest() for part in (render_html, render_pdf)]
    code = (
        "import hashlib, sys, test_report as t\n"
        "from vireport.scenario import load\n"
        "model = t.model_of(t.analyse(load(sys.argv[1])))\n"
        "print(*(hashlib.sha256(part(model)).hexdigest() for part in (t.render_html, t.render_pdf)))"
    )
    environment = {
        **os.environ,
        "PYTHONHASHSEED": "7",
        "PYTHONPATH": f"{ROOT}{os.pathsep}{Path(__file__).parent}",
        "TZ": "Asia/Tokyo",
    }
    command = [sys.executable, "-c", code, str(example("inclined"))]
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.split() == here


def test_nothing_of_the_machine_in_the_report(model) -> None:
    html, pdf = render_html(model("inclined")), render_pdf(model("inclined"))
    for data in (html, pdf):
        for trace in (str(ROOT), gettempdir()):
            assert trace.encode() not in data
    assert PdfReader(BytesIO(pdf)).metadata.creation_date is None


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
    found = page("inclined")
    assert all(url.startswith(("#", "data:")) for name in ("href", "src") for url in found.attributes(name))
    tags = {tag for tag, _ in found.tags}
    assert not tags & {"iframe", "object", "embed", "form"}
    assert scripts(found) == ["application/json", None]
    policy = next(a["content"] for t, a in found.tags if t == "meta" and a.get("http-equiv"))
    assert policy is not None
    assert policy.startswith("default-src 'none';")
    for template in TEMPLATES.glob("*.j2"):
        assert "@preview" not in template.read_text(encoding="utf-8")
    assert "url(" not in (TEMPLATES / "_style.css").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_accessible(name: str, page) -> None:
    found = page(name)
    assert dict(found.tags)["html"]["lang"] == "en"
    ids = found.attributes("id")
    assert len(ids) == len(set(ids))
    references = [url[1:] for url in found.attributes("href") if url.startswith("#")]
    references += found.attributes("aria-labelledby")
    assert set(references) <= set(ids)
    for tag, attributes in found.tags:
        if tag == "img":
            assert attributes["alt"]
            assert attributes["width"]
        if tag == "th":
            assert attributes["scope"] in ("col", "row")
        if tag == "math":
            assert attributes["alttext"]
    assert [tag for tag, _ in found.tags].count("h1") == 1


@pytest.mark.parametrize("name", NAMES)
def test_pdf_ua_1(name: str, model) -> None:
    reader = PdfReader(BytesIO(render_pdf(model(name), standards=["ua-1"])))
    assert reader.trailer["/Root"]["/MarkInfo"]["/Marked"]
    assert reader.trailer["/Root"]["/Lang"] == "en"


def test_pages_are_numbered(reader) -> None:
    pages = reader("inclined")[0].pages
    for i, sheet in enumerate(pages, 1):
        assert f"Page {i} of {len(pages)}" in tidy(sheet.extract_text())


@pytest.mark.slow
def test_a_real_report_is_small(study_of) -> None:
    from vireport.figures import pictures

    study = study_of("horizontal")
    html = render_html(model_of(study, pictures(study)))
    assert len(html) < 1_000_000
    assert html.count(b'<svg xmlns="http://www.w3.org/2000/svg"') == 5


def test_a_users_templates_win_file_by_file(model, tmp_path: Path) -> None:
    (tmp_path / "_style.css").write_text("body { color: rebeccapurple }")
    html = render_html(model("design-point"), tmp_path)
    assert b"rebeccapurple" in html
    assert b"--good:" not in html
    assert b"<h2" in html
    (tmp_path / "report.typ.j2").write_text(
        "#set document(title: {{ report.title | string }})\n= Ours\n{{ report.title }}"
    )
    pdf = PdfReader(BytesIO(render_pdf(model("design-point"), tmp_path)))
    assert tidy(pdf.pages[0].extract_text()) == f"Ours {model('design-point').title}"
    assert b"rebeccapurple" not in render_html(model("design-point"))


@pytest.mark.parametrize(("file", "render"), [("report.html.j2", render_html), ("report.typ.j2", render_pdf)])
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("\n\n{{ report.nonsense }}", "nonsense"),
        ("\n\n{{ nonsense }}", "nonsense"),
        ("\n\n{% if %}", "Expected"),
    ],
)
def test_a_mistake_in_a_template_is_placed(file: str, render, text: str, says: str, model, tmp_path: Path) -> None:
    (tmp_path / file).write_text(text)
    with pytest.raises(RenderError, match=f"{file}:3: .*{says}") as caught:
        render(model("design-point"), tmp_path)
    assert caught.value.exit_code == 3


def test_a_mistake_in_an_included_template_is_placed_there(model, tmp_path: Path) -> None:
    (tmp_path / "_blocks.html.j2").write_text(
        "{% macro block(x, id) %}\n{{ x.nonsense }}\n{% endmacro %}\n"
        + "{% macro icon(s) %}{% endmacro %}{% macro favicon(s) %}{% endmacro %}"
    )
    with pytest.raises(RenderError, match=r"_blocks\.html\.j2:2: .*nonsense"):
        render_html(model("design-point"), tmp_path)


def test_a_mistake_in_typst_is_shown_without_our_folders(model, tmp_path: Path) -> None:
    (tmp_path / "report.typ.j2").write_text("= Head\n\n#nonsense(1)\n" + "x" * 400)
    with pytest.raises(RenderError, match="unknown variable: nonsense") as caught:
        render_pdf(model("design-point"), tmp_path)
    message = str(caught.value)
    assert "report.typ.j2, filled:3:1" in message
    assert "/tmp" not in message
    assert max(map(len, message.splitlines())) <= 160


def test_a_missing_folder_of_templates(model, tmp_path: Path) -> None:
    for render in (render_html, render_pdf):
        with pytest.raises(UsageError, match="no such folder of templates"):
            render(model("design-point"), tmp_path / "nowhere")


def test_a_long_scenario_is_attached_and_not_printed(example) -> None:
    text = example("design-point").read_text(encoding="utf-8") + "# filler\n" * 2000
    model = model_of(analyse(loads(text, "long.yaml")), ())
    assert not any(isinstance(block, Listing) for section in model.sections for block in section.blocks)
    pdf = PdfReader(BytesIO(render_pdf(model)))
    assert pdf.attachments["scenario.yaml"][0].decode() == text
    assert len(pdf.pages) < 8


def equation_tool():
    spec = importlib.util.spec_from_file_location("make_equations", ROOT / "tools" / "make_equations.py")
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    return tool


def test_generated_equations_are_those_of_the_source() -> None:
    tool = equation_tool()
    source = tool.entries((ROOT / "tools" / "equations.typ").read_text(encoding="utf-8"))
    generated = json.loads((TEMPLATES / "equations.json").read_text(encoding="utf-8"))
    assert list(generated) == list(source)
    assert tool.with_mathml(source) == generated
    used = [name for _, _, names in (*GROUPS, ENERGY) for name in names]
    assert sorted(used) == sorted(generated)


def test_accents_stand_above_their_letters() -> None:
    text = (TEMPLATES / "equations.json").read_text(encoding="utf-8")
    assert not set(text) & {"\u0304", "\u0307", "\u0308"}
    assert {"˙", "¯", "¨"} <= set(text)


def test_the_font_has_every_letter_of_the_equations() -> None:
    tool = pytest.importorskip("fontTools.ttLib")
    pytest.importorskip("brotli")
    font = tool.TTFont(TEMPLATES / "math.woff2")
    generated = json.loads((TEMPLATES / "equations.json").read_text(encoding="utf-8"))
    letters = set("".join(re.sub(r"<[^>]*>", "", each["mathml"]) for each in generated.values()))
    assert letters - {" "} <= set(map(chr, font.getBestCmap()))
    assert "MATH" in font


def test_every_equation_has_words_and_stands_in_both_outputs(model, page, reader) -> None:
    found = [block for section in model("inclined").sections for block in section.blocks if isinstance(block, Equation)]
    assert len(found) > 20
    assert set(page("inclined").attributes("alttext")) == {block.alt for block in found}
    for block in found:
        if block.number:
            assert f"({block.number})" in page("inclined").text
            assert f"({squeeze(block.number)})" in reader("inclined")[1]


def test_provenance_is_enough_to_repeat(model, page) -> None:
    made = model("inclined").provenance
    for text in (
        made.version,
        made.scenario_sha256,
        made.python,
        made.command,
        *(f"{n} {v}" for n, v in made.libraries),
    ):
        assert text in page("inclined").text
    assert {name for name, _ in made.libraries} == {
        "jinja2",
        "matplotlib",
        "numpy",
        "pydantic_core",
        "typst",
        "yaml",
    }
    assert replace(made, timestamp=None).epoch == 0


def test_the_margin_names_the_pitchfork_on_the_way(study_of):
    """A symmetric motion gives way to asymmetric ones before the stable range ends."""
    margin = next(fact for fact in study_of("horizontal").verdict.facts if fact.question is Question.MARGIN)
    assert "period doubling B1" in margin.short
    assert "0.396734 m (C1)" in margin.detail
    inclined = next(fact for fact in study_of("inclined").verdict.facts if fact.question is Question.MARGIN)
    assert "take over" not in inclined.detail
