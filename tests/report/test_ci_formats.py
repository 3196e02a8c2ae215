"""JUnit, Markdown and annotations say what the requirements say, to the programs that read them."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from conftest import EXAMPLES, markdown
from junitparser import Failure, JUnitXml
from msgspec.structs import replace
from pages import Page, render_html

from vireport import analyse, load, loads
from vireport.cli.app import main
from vireport.report.ci_formats import github, junit
from vireport.report.context import Report
from vireport.scenario.document import read
from vireport.study.plan import ALL_FORMATS, FORMATS
from vireport.study.provenance import provenance_of

ROOT = EXAMPLES.parent
CI = EXAMPLES / "ci"


def test_formats_for_jobs_are_written_only_when_asked_for(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert FORMATS == ("html", "pdf", "png", "json", "csv")
    assert set(ALL_FORMATS) - set(FORMATS) == {"svg", "figure-pdf", "junit", "markdown", "github"}
    folder = tmp_path / "out"
    assert main([str(CI / "failing.yaml"), "-o", str(folder), "--format", "github"]) == 1
    out, err = capfd.readouterr()
    assert not folder.exists()
    assert out.count("::error ") == 4
    assert "::" not in err
    assert main(["check", str(CI / "failing.yaml"), "--format", "junit"]) == 0
    out = capfd.readouterr().out
    assert re.search(r"run +junit", out)
    assert not re.search(r"(markdown|github)", out)


def test_junit_is_read_by_a_parser() -> None:
    study = analyse(load(CI / "failing.yaml"))
    assert junit(study) == junit(study)
    parsed = JUnitXml.fromstring(junit(study))
    (suite,) = parsed
    cases = list(suite)
    assert (parsed.tests, parsed.failures, parsed.errors) == (suite.tests, suite.failures, suite.errors) == (9, 4, 0)
    assert (len(cases), sum(not case.is_passed for case in cases)) == (9, 4)
    for case, criterion in zip(cases, study.criteria, strict=True):
        assert case.name == f"{criterion.title}: {criterion.limit.text}"
        assert case.is_passed is criterion.passed
        if not criterion.passed:
            (failure,) = case.result
            assert isinstance(failure, Failure)
            assert str(criterion.outcome.text) in failure.message
            assert failure.type == criterion.key


def test_junit_without_requirements_is_one_case(study_of) -> None:
    (suite,) = JUnitXml.fromstring(junit(study_of("inclined")))
    (case,) = suite
    assert (case.name, case.is_passed, suite.tests, suite.failures) == ("solved", True, 1, 0)


TITLE = "<script>|%0A`x` *y* _z_ [l](u) & ~s~ $m$: {{ 1 }} #panic() \u05d0\u05d1 ]]> \\|"


@pytest.fixture(scope="module")
def odd():
    text = (CI / "failing.yaml").read_text()
    title = "title: Capsule at 45 degrees, refused"
    assert title in text
    return analyse(loads(text.replace(title, f"title: '{TITLE}'"), "odd,na:me%.yaml"))


def test_a_title_is_text_in_every_format(odd) -> None:
    (suite,) = JUnitXml.fromstring(junit(odd))
    assert suite.name == TITLE
    text = markdown(odd, "vireport run `a`|<b>.yaml")
    head = "## Requirements not met: &lt;script&gt;\\|%0A\\`x\\` \\*y\\* \\_z\\_ \\[l\\](u) &amp; \\~s\\~ \\$m\\$: "
    assert text.splitlines()[0] == f"{head}{{{{ 1 }}}} #panic() \u05d0\u05d1 \\]\\]&gt; \\\\\\|"
    assert set(re.findall(r"<[^>]*>", text)) == {"<sub>", "</sub>", "<b>"}
    assert "`` vireport run `a`|<b>.yaml ``" in text
    rows = re.search(r"(?:^\|.*\n)+", text[text.index("## Acceptance") :], re.MULTILINE)[0].splitlines()
    assert len(rows) == 2 + 9
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {7}
    assert sum("NOT MET" in row for row in rows) == 4


def test_markdown_leads_to_the_line_and_says_how_to_run_it_again(odd, monkeypatch: pytest.MonkeyPatch) -> None:
    text = markdown(odd, "vireport run x_y.yaml")
    assert "To repeat this with its exit code: `vireport run x_y.yaml`" in text
    assert "| odd,na:me%.yaml:28 |" in text
    for name, value in (("SERVER_URL", "https://github.com"), ("REPOSITORY", "a/b"), ("SHA", "0123")):
        monkeypatch.setenv(f"GITHUB_{name}", value)
    text = markdown(odd, "test")
    assert "[odd,na:me%.yaml:28](https://github.com/a/b/blob/0123/odd%2Cna%3Ame%25.yaml#L28)" in text


def test_characters_that_xml_cannot_hold(odd) -> None:
    loaded = replace(odd.loaded, document=replace(odd.loaded.document, name="a\x1b\udcff.yaml"))
    study = replace(odd, loaded=loaded)
    (suite,) = JUnitXml.fromstring(junit(study))
    assert len(list(suite)) == 9
    github(study).encode()


def test_annotations_point_to_the_lines(odd) -> None:
    lines = github(odd).splitlines()
    failed = [criterion for criterion in odd.criteria if not criterion.passed]
    errors = [line for line in lines if line.startswith("::error ")]
    rows = odd.loaded.document.text.splitlines()
    assert len(errors) == len(failed) == 4
    for line, unmet in zip(errors, failed, strict=True):
        parts = re.fullmatch(r"::error file=odd%2Cna%3Ame%25\.yaml,line=(\d+),title=([^:,]*)::(.*)", line)
        assert parts
        assert rows[int(parts[1]) - 1].split(":")[0].strip() == unmet.key
        assert not re.search(r"%(?!25|0A|0D|3A|2C)", parts[2] + parts[3])
    warnings = [line for line in lines if line.startswith("::warning ")]
    assert len(warnings) == sum(alert.severity == "warning" for alert in odd.alerts) > 0
    assert len(lines) == len(errors) + len(warnings)


@pytest.mark.slow
def test_annotations_are_seen_from_the_root_of_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_WORKSPACE", str(ROOT))
    monkeypatch.chdir(CI)
    assert "::error file=examples/ci/failing.yaml,line=28," in github(analyse(load("failing.yaml")))
    standard_input = analyse(loads((CI / "failing.yaml").read_text(), "<stdin>"))
    assert github(standard_input).startswith("::error title=")


def test_what_is_set_over_the_file_has_no_line() -> None:
    study = analyse(load(CI / "passing.yaml", {"requirements.u_ave_at_least_v": 1e6}))
    (missed,) = (criterion for criterion in study.criteria if not criterion.passed)
    assert (missed.key, missed.line) == ("u_ave_at_least_v", None)
    assert "::error file=" in github(study)
    assert "line=" not in github(study).split("::")[1]
    assert f"::{missed.outcome.text}, required {missed.limit.text}" in github(study)
    assert sum(criterion.line is None for criterion in study.criteria) == 1
    whole = analyse(load(CI / "passing.yaml", {"requirements": {"u_ave_at_least_v": 1}}))
    assert [criterion.line for criterion in whole.criteria] == [None]


@pytest.mark.slow
def test_the_report_opens_with_the_table(tmp_path: Path, study_of) -> None:
    assert main([str(CI / "failing.yaml"), "-o", str(tmp_path), "--format", "html", "-q"]) == 1
    page = Page((tmp_path / "report.html").read_bytes())
    assert page.headings[1:3] == ["Acceptance", "Margins"]
    outcomes = [outcome for (outcome,) in page.tables["Requirements"].columns("Outcome")]
    assert (outcomes.count("✗ NOT MET"), outcomes.count("✓ met")) == (4, 5)
    lines = page.tables["Requirements"].columns("In the scenario")
    rows = (CI / "failing.yaml").read_text().splitlines()
    for (line,), criterion in zip(lines, analyse(load(CI / "failing.yaml")).criteria, strict=True):
        name, _, number = line.partition(":")
        assert (name, rows[int(number) - 1].split(":")[0].strip()) == ("failing.yaml", criterion.key)
        assert f"#line-{number}" in page.attributes("href")
    assert "vireport" in page.text[page.text.index("To repeat this with its exit code") :][:80]
    plain = Report(study_of("inclined"), {}, provenance_of(study_of("inclined").loaded, "test"))
    assert "Acceptance" not in Page(render_html(plain)).headings


@pytest.mark.slow
def test_the_workflow_runs_what_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    workflow = read((CI / "vireport.yml").read_text(), "vireport.yml")
    assert not workflow.mistakes
    job = workflow.data["jobs"]["acceptance"]
    assert (ROOT / job["env"]["SCENARIO"]).is_file()
    commands = [shlex.split(step["run"]) for step in job["steps"] if step.get("run", "").startswith("vireport ")]
    assert len(commands) == 1
    summary = tmp_path / "summary"
    monkeypatch.chdir(tmp_path)
    arguments = [str(ROOT / job["env"]["SCENARIO"]) if word == "$SCENARIO" else word for word in commands[0][1:]]
    assert main(arguments) == 0
    (step,) = (step for step in job["steps"] if "GITHUB_STEP_SUMMARY" in step.get("run", ""))
    environment = {"GITHUB_STEP_SUMMARY": str(summary), "PATH": "/usr/bin:/bin"}
    subprocess.run(["bash", "-e", "-c", step["run"]], env=environment, check=True)
    title = "## Stable, margin to use less than required: Capsule at 45 degrees, accepted\n"
    assert summary.read_text().startswith(title)
    (upload,) = (step for step in job["steps"] if "upload-artifact" in step.get("uses", ""))
    assert Path(upload["with"]["path"]).is_dir()


def steps_of(file: Path) -> list[dict]:
    read_in = yaml.safe_load(file.read_text())
    return read_in["runs"]["steps"] if "runs" in read_in else read_in["jobs"]["acceptance"]["steps"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "code"), [("passing", 0), ("failing", 1)])
def test_the_action_runs_what_it_says(name: str, code: int, tmp_path: Path) -> None:
    """Its steps in a shell, with the inputs as GitHub hands them over; nothing is installed."""
    action = yaml.safe_load((CI / "action" / "action.yml").read_text())
    assert action["runs"]["using"] == "composite"
    assert {key for key, of in action["inputs"].items() if of.get("required")} == {"scenario"}
    given = {key: of.get("default") for key, of in action["inputs"].items()}
    given |= {"scenario": str(CI / f"{name}.yaml"), "output": "report of $(touch harm); it", "package": "vireport"}
    (tmp_path / "pip.py").write_text("import sys; print('pip', *sys.argv[1:])")
    environment = {"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin", "PYTHONPATH": str(tmp_path)}
    environment["GITHUB_STEP_SUMMARY"] = str(tmp_path / "summary")
    codes, printed = [], []
    for step in action["runs"]["steps"]:
        assert "${{" not in step.get("run", "")
        if "run" in step:
            assert step["shell"] == "bash"
            own = {
                key: given[text.removeprefix("${{ inputs.").removesuffix(" }}")] for key, text in step["env"].items()
            }
            ran = ["bash", "-eo", "pipefail", "-c", step["run"]]
            done = subprocess.run(ran, env=environment | own, cwd=tmp_path, capture_output=True, text=True)
            codes.append(done.returncode)
            printed.append(done.stdout)
    assert codes == [0, code, 0]
    assert printed[0] == "pip install vireport\n"
    assert (printed[1].count("::error ") > 0) == (code > 0)
    folder = tmp_path / given["output"]
    assert {"report.html", "report.pdf", "junit.xml", "summary.md"} <= {path.name for path in folder.iterdir()}
    assert (tmp_path / "summary").read_text() == (folder / "summary.md").read_text()
    assert not (tmp_path / "harm").exists()


def test_the_action_has_the_steps_of_the_workflow() -> None:
    action, workflow = (steps_of(CI / name) for name in ("action/action.yml", "vireport.yml"))
    assert [step["name"] for step in action if "name" in step] == [step["name"] for step in workflow if "name" in step]
    used = {step["uses"] for step in workflow if "uses" in step} - {"actions/checkout@v4"}
    assert {step["uses"] for step in action if "uses" in step} == used
    (run,) = (step["run"] for step in action if step.get("run", "").startswith("vireport "))
    inputs = yaml.safe_load((CI / "action" / "action.yml").read_text())["inputs"]
    run = run.replace('"$OUTPUT"', inputs["output"]["default"]).replace('"$FORMATS"', inputs["formats"]["default"])
    assert run in [step.get("run") for step in workflow]
