"""The command line as its users meet it: exit codes, streams, files, messages."""

from __future__ import annotations

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from bad_scenarios import SEVERAL
from conftest import EXAMPLES

from vireport.base.additions import ADDITIONS
from vireport.cli.app import main, program


def accept_ctrl_c() -> None:
    """In a child: take Ctrl-C, also where the tests were started in the background of a script and ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def vireport(
    *arguments: str, stdin: bytes = b"", cwd: Path | None = None, **environment: str
) -> subprocess.CompletedProcess[bytes]:
    command, env = [sys.executable, "-m", "vireport", *arguments], os.environ | environment
    return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, env=env)


FIGURES = {f"figure-{name}.png" for name in ("2", "4", "7")}
ALL = {"report.html", "report.pdf", "results.json", "branches.csv"} | FIGURES


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inclined", "inclined-forcing"])
def test_every_output_of_an_example(name: str, example, tmp_path: Path) -> None:
    run = vireport(str(example(name)), cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    folder = tmp_path / name
    assert {path.name for path in folder.iterdir()} == ALL
    assert run.stdout.startswith(b"It runs, and starts by itself")
    assert run.stdout.count(b"\n") == 3
    assert b"wrote" in run.stderr
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF-")
    assert (folder / "figure-2.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_design_point_draws_no_bifurcation_figure(example, tmp_path: Path) -> None:
    run = vireport(str(example("design-point")), "-o", str(tmp_path / "out"))
    assert run.returncode == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "report.html", "report.pdf", "results.json", "figure-device.png", "figure-margins.png"
    }  # fmt: skip


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(example, tmp_path: Path) -> None:
    """In another process, at another place of the Earth, with other hashes."""
    digests = []
    for folder, given in (("one", {}), ("two", {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"})):
        vireport(str(example("horizontal")), "-o", str(tmp_path / folder), **given)
        digests.append({p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in (tmp_path / folder).iterdir()})
    assert digests[0] == digests[1]
    assert set(digests[0]) == ALL


@pytest.mark.slow
def test_json_is_alone_on_stdout_and_writes_no_file(example, tmp_path: Path) -> None:
    run = vireport("run", str(example("inclined")), "--json", cwd=tmp_path)
    assert run.returncode == 0
    assert run.stderr == b""
    assert json.loads(run.stdout)["schema_version"] == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_default_command_and_run_are_the_same(example) -> None:
    short, full = vireport(str(example("inclined")), "--json"), vireport("run", str(example("inclined")), "--json")
    assert short.stdout == full.stdout
    assert vireport("--json", str(example("inclined"))).stdout == short.stdout


@pytest.mark.slow
def test_standard_input(example, tmp_path: Path) -> None:
    text = example("inclined").read_bytes()
    results = json.loads(vireport("-", "--json", stdin=text).stdout)
    assert results["critical_points"]
    run = vireport("-", "--format", "csv", stdin=text, cwd=tmp_path)
    assert run.returncode == 0
    assert (tmp_path / "stdin" / "branches.csv").exists()


def test_overrides_reach_the_results(example, capsys) -> None:
    main([str(example("inclined")), "--json", "--set", "device.restitution=0.6", "--set", "inclination_deg=30"])
    scenario = json.loads(capsys.readouterr().out)["scenario"]
    assert scenario["device"]["restitution"] == 0.6
    assert scenario["inclination_deg"] == 30


@pytest.mark.slow
def test_formats_narrow_what_is_written(example, tmp_path: Path) -> None:
    run = vireport(str(example("inclined")), "-o", str(tmp_path / "a/b"), "--format", "csv,json", "--format", "png")
    assert run.returncode == 0
    on_pages = {f"figure-{name}.png" for name in ("answer", "device", "margins")}
    assert {path.name for path in (tmp_path / "a/b").iterdir()} == ALL - {"report.html", "report.pdf"} | on_pages


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["nothing.yaml"], "nothing.yaml"),
        (["validat", "x.yaml"], "did you mean the command 'validate'"),
        (["rnu", "x.yaml"], "did you mean the command 'run'"),
        (["xyzw", str(EXAMPLES / "inclined.yaml")], "there is no command 'xyzw' (allowed: run, check, "),
        (["run"], "Missing argument"),
        (["--nope", "x.yaml"], "No such option"),
        (["run", "examples/inclined.yaml", "--format", "docx"], "allowed: html, pdf"),
        (["run", "examples/inclined.yaml", "--json", "-o", "x"], "leave out --output"),
        (["run", "examples/inclined.yaml", "--set", "device.lenght_m=1"], "did you mean"),
        (["run", "examples"], "folder"),
        (["run", "examples/inclined.yaml", "-o", "/dev/null/x"], "cannot be written"),
        (["run", "examples/inclined.yaml", "--templates", "no-such-folder"], "no-such-folder"),
    ],
)
def test_usage_mistakes(arguments: list[str], fragment: str, monkeypatch, capfd) -> None:
    monkeypatch.chdir(EXAMPLES.parent)
    assert main(arguments) == 2
    out, err = capfd.readouterr()
    assert fragment in err
    assert "Traceback" not in err
    assert out == ""


def test_what_is_no_option_is_said_like_any_other_mistake(capfd) -> None:
    assert main(["check", "--nope", "x.yaml"]) == 2
    mistake, advice = capfd.readouterr().err.splitlines()
    assert mistake.startswith("vireport: error: No such option: --nope")
    assert advice == "vireport check --help lists the options"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "next_word"),
    [("vireport x.yaml --js", "--json"), pytest.param("vireport veri", "verify", marks=pytest.mark.slow)],
)
def test_a_shell_completes_commands_and_the_options_of_run(words: str, next_word: str) -> None:
    asked = {**os.environ, "_VIREPORT_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": words}
    shell = subprocess.run([sys.executable, "-m", "vireport"], env=asked, capture_output=True, text=True)
    assert shell.returncode == 0, shell.stderr
    assert f'"{next_word}"' in shell.stdout


def test_the_script_of_completion_is_printed() -> None:
    """For the shell that asks."""
    command = f"{sys.executable} -m vireport --show-completion; exit $?"
    shell = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert (shell.returncode, shell.stderr) == (0, "")
    assert "_VIREPORT_COMPLETE=complete_bash" in shell.stdout
    assert shell.stdout.rstrip().endswith("vireport")


def test_completion_is_installed_where_the_shell_looks_for_it(tmp_path: Path) -> None:
    command = f"{sys.executable} -m vireport --install-completion; exit $?"
    home = {**os.environ, "HOME": str(tmp_path)}
    shell = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=home)
    assert (shell.returncode, shell.stderr) == (0, "")
    (script,) = (path for path in tmp_path.rglob("*") if path.name.startswith("vireport"))
    assert "_VIREPORT_COMPLETE=complete_bash" in script.read_text()


@pytest.mark.parametrize("bad", SEVERAL, ids=lambda bad: bad.name)
def test_a_broken_scenario_exits_with_2_and_no_traceback(
    bad, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.yaml"
    path.write_bytes(bad.text if isinstance(bad.text, bytes) else bad.text.encode("utf-8", "surrogatepass"))
    assert main(["check", str(path)]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert "Traceback" not in err
    for line, key, fragment in bad.expected:
        assert any(
            report.startswith(f"{path}:{line}: ") and key in report and fragment in report
            for report in err.splitlines()
        ), (line, key, fragment, err)


def test_a_real_process_refuses_a_broken_scenario(tmp_path: Path) -> None:
    (tmp_path / "x.yaml").write_text("schema_version: 1\ndevice: [1]\n")
    run = vireport("x.yaml", cwd=tmp_path)
    assert run.returncode == 2
    assert run.stderr.decode().startswith("x.yaml:")
    assert list(tmp_path.iterdir()) == [tmp_path / "x.yaml"]


def test_a_case_outside_the_theory_exits_with_3(example, capfd) -> None:
    assert main([str(example("inclined")), "--json", "--set", "device.restitution=1"]) == 3
    err = capfd.readouterr().err
    assert "restitution" in err
    assert "Traceback" not in err


def test_a_check_says_what_runs_and_what_is_left_out(example, capfd) -> None:
    def plan(name: str, *more: str) -> list[str]:
        assert main(["check", str(example(name)), *more]) == 0
        said, *rows = capfd.readouterr().out.splitlines()
        assert said == f"{example(name)}: valid scenario"
        return rows

    def steps(rows: list[str]) -> set[str]:
        return {row.split()[1] for row in rows if row.startswith("run  ")}

    rows = plan("design-point")
    assert "design" in steps(rows)
    assert "figure-2" not in steps(rows)
    blocks, inputs, every_step = [row for row in rows if not row.startswith("run  ")]
    assert blocks.startswith("Add disturbances: for shocks, " if "outcomes" in ADDITIONS else "Add ")
    assert inputs.startswith("Give sweep: for branches, ")
    assert "results.json (left_out)" in every_step
    assert "figure-2" in steps(plan("horizontal"))
    assert "figure-2" not in steps(plan("horizontal", "--format", "json"))
    assert main(["check", str(example("horizontal")), "--json"]) == 0
    listed = json.loads(capfd.readouterr().out)["steps"]
    left_out = {row["step"]: row["why"] for row in listed if not row["runs"]}
    assert "thickness_m" in left_out.pop("conversion")
    named = {"accuracy": "accuracy", "compliant": "accuracy", "tolerances": "tolerances", "motions": "motions"}
    named |= dict.fromkeys(("simulation", "figure-3", "figure-6", "figure-diagram"), "simulation")
    asked = "distortion", "from-rest-moments", "from-rest-windows", "shock", "coexistence", "figure-shocks", "jitter"
    for name in {*named, *asked} & {row["step"] for row in listed}:
        assert f"{named.get(name, 'disturbances')} block" in left_out[name]


@pytest.mark.slow
def test_without_a_ball_mass_no_energy_is_evaluated(example, tmp_path: Path) -> None:
    text = "".join(
        line
        for line in example("inclined").read_text().splitlines(keepends=True)
        if not line.lstrip().startswith("ball_mass_kg")
    )
    (tmp_path / "massless.yaml").write_text(text)
    run = vireport("massless.yaml", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    assert {path.name for path in (tmp_path / "massless").iterdir()} == ALL - {"figure-7.png"}
    results = json.loads((tmp_path / "massless/results.json").read_text())
    assert "u_ave_v" not in results["branches"][0]
    assert any("ball_mass_kg" in entry["why"] for entry in results["left_out"])


@pytest.mark.slow
def test_init_writes_a_scenario_that_runs_and_never_overwrites(tmp_path: Path) -> None:
    assert vireport("init", cwd=tmp_path).returncode == 0
    assert vireport("check", "scenario.yaml", cwd=tmp_path).returncode == 0
    assert vireport("scenario.yaml", "--json", cwd=tmp_path).returncode == 0
    before = (tmp_path / "scenario.yaml").read_bytes()
    again = vireport("init", cwd=tmp_path)
    assert again.returncode == 2
    assert b"exists already" in again.stderr
    assert (tmp_path / "scenario.yaml").read_bytes() == before


def test_schema_prints_what_the_examples_come_with() -> None:
    assert vireport("init", "--schema").stdout == (EXAMPLES / "scenario.schema.json").read_bytes()


def test_every_command_is_listed_once_with_what_it_is_for() -> None:
    text = vireport("--help").stdout.decode()
    listed = re.findall(r"^  (\w+)  +[A-Z]", text, re.MULTILINE)
    assert sorted(listed) == sorted(program().commands)
    assert "..." not in text.partition("\n\nOne device:")[2]


def test_the_help_of_every_option_and_argument_is_a_sentence() -> None:
    for name, command in program().commands.items():
        for parameter in command.params:
            told = parameter.help
            assert re.fullmatch(r"[A-Z][a-z]*s\b.*\.", told, re.DOTALL), f"{name} {parameter.name}: {told}"


def test_an_option_means_the_same_in_every_command() -> None:
    found: dict[tuple[str, ...], set[tuple[object, ...]]] = {}
    for command in program().commands.values():
        for own in command.params:
            if own.param_type_name == "option" and "--format" not in own.opts:  # of which each command has its list
                meaning = (own.help, own.metavar, own.nargs, repr(own.default), own.rich_help_panel)
                found.setdefault((*own.opts, *own.secondary_opts), set()).add(meaning)
    assert {flags: told for flags, told in found.items() if len(told) > 1} == {}
    assert len({flag for flags in found for flag in flags}) == sum(map(len, found))


@pytest.mark.slow
def test_the_help_of_a_command_groups_its_options_as_that_of_the_others() -> None:
    for name in ("run", "compare", "map", "optimise", "identify", "verify"):
        text = vireport(name, "--help").stdout.decode()
        heads = re.findall(r"^([A-Z]\w+):$", text, re.MULTILINE)
        assert heads == ["Options", "Output", "Messages"], name
        assert text.index("--set") < text.index("\nOutput:") < text.index("--json") < text.index("\nMessages:")


def test_version_and_no_command() -> None:
    assert vireport("--version").stdout.startswith(b"vireport ")
    assert vireport().returncode == 2


@pytest.mark.slow
def test_a_reader_that_goes_away_is_no_error(example) -> None:
    command = f"{sys.executable} -m vireport {example('inclined')} --json | head -c 10"
    run = subprocess.run(command, shell=True, capture_output=True)
    assert b"Traceback" not in run.stderr
    assert run.stdout == b'{\n"schema_'


def test_ctrl_c_of_a_real_process(example, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "vireport", "-", "-o", str(tmp_path / "out")],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=accept_ctrl_c,
    )
    time.sleep(1.0)  # it waits for its scenario
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert b"Traceback" not in err
