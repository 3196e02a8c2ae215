"""Streams that are closed, full or broken, Ctrl-C at any moment, names that are traps, and results of several runs."""

from __future__ import annotations

import errno
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from conftest import first

from vireport.cli.app import main

ROOT = Path(__file__).resolve().parents[2]
INCLINED, DESIGN = (str(ROOT / "examples" / f"{name}.yaml") for name in ("inclined", "design-point"))
ENTRY = [sys.executable, "-m", "vireport"]

# Two commands that would take long: they do the same with one case, and one method.
QUICK = (
    "import sys; from vireport.verify import catalogue; from vireport.verify.rows import Case, CaseFinding;"
    "catalogue.catalogue = lambda loaded=None: [Case('a', 'b', lambda: CaseFinding(''))];"
    "from vireport.findings.accuracy import workprecision as w; w.METHODS = w.METHODS[:1];"
    "from vireport.__main__ import entry; sys.exit(entry())"
)
SHORT = [sys.executable, "-c", QUICK]

COMMANDS = {
    "run": ([*ENTRY, "run", INCLINED, "-o", "out", "--format", "json"], True),
    "run --json": ([*ENTRY, INCLINED, "--json"], True),
    "requirement": ([*ENTRY, str(ROOT / "examples/ci/failing.yaml"), "--json"], True),
    "validate": ([*ENTRY, "check", INCLINED], True),
    "plan": ([*ENTRY, "check", "--json", INCLINED], True),
    "schema": ([*ENTRY, "init", "--schema"], True),
    "init": ([*ENTRY, "init", "-"], True),
    "explain": ([*ENTRY, "explain"], True),
    "help": ([*ENTRY, "--help"], True),
    "version": ([*ENTRY, "--version"], True),
    "wrong": ([*ENTRY, "run", "--nope"], False),
    "diff": ([*ENTRY, "compare", "--exit-code", "old.json", INCLINED, "--set", "device.restitution=0.51"], True),
    "compare": ([*ENTRY, "compare", INCLINED, "--vary", "inclination_deg=30,45", "--json"], True),
    "accuracy": ([*SHORT, "verify", INCLINED, "--set", "accuracy.compliant_membrane=false"], True),
    "extremes": ([*SHORT, "verify", "--extremes"], True),
    "sweep": ([*ENTRY, "map", "map.yaml", "-o", "map", "--no-figures", "--workers", "1"], True),
}
CODES = {"requirement": 1, "diff": 1, "wrong": 2}

OUTPUTS = ("ordinary", "closed", "full", "broken")
INPUTS = ("ordinary", "closed")


def started(command: list[str], cwd: Path, stdin: str, stdout: str, stderr: str) -> tuple[int, bytes, bytes]:
    """Exit code, output and messages of a process whose streams are what they are called."""
    redirected = [f"exec {shlex.join(command)}", "<&-" if stdin == "closed" else "</dev/null"]
    for number, kind in ((1, stdout), (2, stderr)):
        redirected += {"closed": [f"{number}>&-"], "full": [f"{number}>/dev/full"]}.get(kind, [])
    (out, out_end), (err, err_end) = os.pipe(), os.pipe()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with os.fdopen(out, "rb") as read_out, os.fdopen(err, "rb") as read_err:
        for stream, kind in ((read_out, stdout), (read_err, stderr)):
            if kind == "broken":
                stream.close()
        process = subprocess.Popen(
            ["bash", "-c", " ".join(redirected)], cwd=cwd, stdout=out_end, stderr=err_end, env=environment
        )
        os.close(out_end)
        os.close(err_end)
        texts = [b"" if stream.closed else stream.read() for stream in (read_out, read_err)]
    return process.wait(60), *texts


def check_streams(name: str, folder: Path, stdin: str, stdout: str, stderr: str) -> None:
    """No traceback, no silence, the right exit code; and what was asked for is there."""
    command, prints = COMMANDS[name]
    code, out, err = started(command, folder, stdin, stdout, stderr)
    lost = prints and stdout in ("closed", "full")
    assert code == (3 if lost else CODES.get(name, 0)), (code, err)
    assert b"Traceback" not in out + err
    assert b"fault of ours" not in err
    assert b"Exception ignored" not in err
    if lost and stderr == "ordinary":
        assert b"standard output cannot be written" in err
    if prints and stdout == "ordinary":
        assert out
    if name == "run":
        assert json.loads((folder / "out" / "results.json").read_bytes())["schema_version"] == 1
        shutil.rmtree(folder / "out")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a map and earlier results."""
    place = tmp_path_factory.mktemp("streams")
    text = (
        (ROOT / "examples/maps/map.yaml").read_text().replace("count: 60", "count: 3").replace("count: 80", "count: 3")
    )
    (place / "map.yaml").write_text(text)
    assert main(["run", INCLINED, "-o", str(place), "--format", "json", "-q"]) == 0
    (place / "results.json").rename(place / "old.json")
    return place


@pytest.mark.parametrize(
    ("name", "stdin", "stdout", "stderr"),
    [
        ("run --json", "closed", "full", "ordinary"),
        pytest.param("plan", "ordinary", "broken", "broken", marks=pytest.mark.slow),
        pytest.param("run", "ordinary", "closed", "closed", marks=pytest.mark.slow),
        pytest.param("requirement", "ordinary", "ordinary", "full", marks=pytest.mark.slow),
    ],
)
def test_streams(name: str, stdin: str, stdout: str, stderr: str, folder: Path) -> None:
    check_streams(name, folder, stdin, stdout, stderr)


@pytest.mark.slow
@pytest.mark.parametrize(("turn", "name"), [*enumerate(COMMANDS)])
def test_combinations_of_streams(turn: int, name: str, folder: Path) -> None:
    """Every state of standard output, and of standard error; the commands take turns in which of them meet.

    Sixteen commands have two pairs each: every pair of states twice.
    """
    for i in (turn % 4, (turn + 2) % 4):
        check_streams(name, folder, INPUTS[(i + turn) % 2], OUTPUTS[i], OUTPUTS[(i + turn // 4) % 4])


def test_standard_input_that_is_closed(tmp_path: Path) -> None:
    code, _, err = started([*ENTRY, "-", "--json"], tmp_path, "closed", "ordinary", "ordinary")
    assert code == 2
    assert err == b"vireport: error: standard input cannot be read (Bad file descriptor)\n"


def interrupted(code: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[bytes]:
    """The command line in a process that interrupts itself where `code` says so."""
    lines = (
        "import os, signal, sys",
        "from vireport.__main__ import entry",
        "def interrupt(*arguments, **named): os.kill(os.getpid(), signal.SIGINT)",
        code,
        "sys.exit(entry())",
    )
    return subprocess.run(
        [sys.executable, "-c", "\n".join(lines), *arguments],
        cwd=cwd,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        capture_output=True,
    )


MOMENTS = {
    "while the command line is imported": """
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == 'typer': interrupt()
sys.meta_path.insert(0, Finder())""",
    "in a library that swallows it": """
import vireport.study.study as s
real = s.analyse
def analyse(*arguments):
    try: interrupt()
    except KeyboardInterrupt: pass
    return real(*arguments)
s.analyse = analyse""",
    "in a library that makes another error of it": """
import vireport.study.study as s
def analyse(*arguments):
    try: interrupt()
    except KeyboardInterrupt: raise SystemError('returned a result with an exception set')
s.analyse = analyse""",
    "where the interpreter cannot raise it": """
import vireport.study.study as s
real = s.analyse
class Gone:
    def __del__(self): interrupt()
def analyse(*arguments):
    Gone()
    return real(*arguments)
s.analyse = analyse""",
    "between writing and renaming": """
from pathlib import Path
real = Path.write_bytes
def write_bytes(path, data):
    real(path, data)
    interrupt()
Path.write_bytes = write_bytes""",
}


EARLIER = '{"provenance": {"version": "0", "scenario_name": "old"}}'
"""Results of an earlier run, as far as they are known by their mark."""


@pytest.mark.slow
@pytest.mark.parametrize("moment", first(3, MOMENTS))
def test_an_interrupt_at_any_moment(moment: str, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "results.json").write_text(EARLIER)
    run = interrupted(MOMENTS[moment], "run", INCLINED, "-o", "out", "--format", "json,csv", cwd=tmp_path)
    assert run.returncode == 130, run.stderr
    assert run.stderr.startswith(b"vireport: interrupted")
    assert b"Traceback" not in run.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["results.json"]
    assert (tmp_path / "out" / "results.json").read_text() == EARLIER


@pytest.mark.slow
def test_an_interrupt_while_files_are_put_in_place(tmp_path: Path) -> None:
    code = "real = os.rename\ndef rename(*x):\n    interrupt()\n    real(*x)\nos.rename = rename"
    run = interrupted(code, "run", INCLINED, "-o", "out", "--format", "json,csv", cwd=tmp_path)
    assert run.returncode == 130
    assert b"interrupted (all was done)" in run.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"results.json", "branches.csv"}


def test_an_interrupt_while_arguments_are_read_does_not_say_that_all_was_done(tmp_path: Path) -> None:
    code = """
import typer, vireport.cli.app
def empty(*arguments, **named):
    try: interrupt()
    except KeyboardInterrupt: pass
    return real(*arguments, **named)
real, typer.BadParameter = typer.BadParameter, empty"""
    run = interrupted(code, "run", INCLINED, "-o", "", cwd=tmp_path)
    assert run.returncode == 130, run.stderr
    assert run.stderr.startswith(b"vireport: interrupted")
    assert b"all was done" not in run.stderr


@pytest.mark.slow
def test_sigterm_ends_a_run_as_ctrl_c_does_and_leaves_no_folder(tmp_path: Path) -> None:
    """It comes when files are written, before they are put in place."""
    code = MOMENTS["between writing and renaming"].replace("interrupt()", "os.kill(os.getpid(), signal.SIGTERM)")
    (tmp_path / "tmp").mkdir()
    code += "\nos.environ['TMPDIR'] = 'tmp'"
    run = interrupted(code, "run", INCLINED, "-o", "out", "--format", "csv,json", cwd=tmp_path)
    assert run.returncode == 143, run.stderr
    assert run.stderr.startswith(b"vireport: interrupted")
    # Templates that are kept compiled for later runs are no files of this one.
    left = [path for path in tmp_path.rglob("*") if path.name != "tmp" and "jinja2-cache" not in str(path)]
    assert left == []


AS_IT_IS_IMPORTED = """
import os, signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "typer":
            exec("os.kill(os.getpid(), signal.{name})")
sys.meta_path.insert(0, Finder())
"""
"""The signal comes in code that is compiled from a string, as that of a template is."""


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_the_exit_code_names_the_signal_wherever_it_comes(name: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(AS_IT_IS_IMPORTED.format(name=name))
    run = subprocess.run(
        [*ENTRY, "run", INCLINED],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        capture_output=True,
    )
    assert run.stderr == b"vireport: interrupted\n"
    assert run.returncode == code


@pytest.mark.slow
def test_an_interrupted_map_says_how_it_goes_on(tmp_path: Path) -> None:
    code = "import vireport.map.cells.run as s\ns.run_map = interrupt"
    run = interrupted(code, "map", "map.yaml", cwd=tmp_path)
    assert run.returncode == 130
    assert b"run the same command again" in run.stderr


def test_a_fault_that_is_no_exception_of_python_is_no_unmet_requirement(monkeypatch, capsys) -> None:
    from vireport.study import plan

    class Panic(BaseException):
        """As an extension module raises it."""

    def panic(*arguments: object) -> None:
        raise Panic("at the disco")

    monkeypatch.setattr(plan, "plan", panic)
    assert main(["check", INCLINED]) == 3
    assert "fault of ours" in capsys.readouterr().err


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.slow
def test_another_scenario_in_the_same_folder_leaves_nothing_of_the_first(tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    assert main(["run", INCLINED, "-o", str(out), "--format", "json,csv"]) == 0
    (out / "figure-2.png").write_bytes(b"\x89PNG\r\n of an earlier run: tEXtSoftware\0vireport 0")
    for name in ("figure-mine.png", "notes.txt"):
        (out / name).write_text("mine")
    assert main(["run", DESIGN, "-o", str(out), "--format", "png,json"]) == 0
    assert names(out) == {
        "results.json",
        "branches.csv",
        "notes.txt",
        "figure-mine.png",
        "figure-device.png",
        "figure-margins.png",
    }
    assert "of an earlier run, and left as they are: branches.csv" in capsys.readouterr().err


@pytest.mark.slow
def test_a_full_disk_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    for arguments in (["run", INCLINED, "-o", "out", "--format", "json"], ["init"]):
        run = subprocess.run(
            [*ENTRY, *arguments],
            cwd=tmp_path,
            capture_output=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)),
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        )
        assert run.returncode == 3, run.stderr
        assert b"cannot be written: File too large" in run.stderr
        assert names(tmp_path) == set()


@pytest.mark.slow
def test_a_report_needs_no_temporary_folder(tmp_path: Path, monkeypatch) -> None:
    """With a full TMPDIR, or one that is not there: what Typst reads is passed in memory."""

    def full(*arguments: object, **named: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile, "mkdtemp", full)
    monkeypatch.setattr(tempfile, "mkstemp", full)
    assert main(["run", INCLINED, "-o", str(tmp_path), "--format", "html,pdf,png,markdown", "-q"]) == 0
    assert {"report.html", "report.pdf", "figure-2.png"} <= names(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        ([DESIGN, "-o", "OUT", "--format", "html,json,github"], 0, b""),
        ([DESIGN], 2, b"design-point cannot be written: the current folder has been deleted"),
        (["compare", DESIGN, "--vary", "inclination_deg=30,45"], 2, b"the current folder has been deleted"),
        (["compare", "results.json", DESIGN, "--exit-code"], 2, b"results.json: cannot be read"),
        (["init"], 2, b"scenario.yaml cannot be written"),
    ],
    ids=["elsewhere", "run", "compare", "exit code", "init"],
)
def test_the_current_folder_may_have_been_deleted(arguments: list[str], code: int, told: bytes, tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    words = [str(tmp_path / "out") if word == "OUT" else word for word in arguments]
    run = subprocess.run(
        ["bash", "-c", f"rmdir ../gone && exec {shlex.join([*ENTRY, *words])}"],
        cwd=tmp_path / "gone",
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
    )
    assert run.returncode == code, run.stderr
    assert told in run.stderr
    assert b"Traceback" not in run.stderr


@pytest.mark.slow
def test_a_folder_may_have_a_name_that_is_not_utf_8(tmp_path: Path, monkeypatch) -> None:
    here = tmp_path / os.fsdecode(b"here\xff")
    here.mkdir()
    monkeypatch.chdir(here)
    folder = os.fsdecode(b"out\xfe")
    assert main(["run", DESIGN, "-o", folder, "--format", "pdf,json", "-q"]) == 0
    assert main(["run", f"{folder}/report.pdf", "-o", "again", "--format", "json", "-q"]) == 0
    pytest.importorskip("pyarrow")
    map_text = (ROOT / "examples/maps/map.yaml").read_text().replace("count: 60", "count: 3")
    Path("map.yaml").write_text(map_text.replace("count: 80", "count: 3"))
    for _ in range(2):
        assert main(["map", "map.yaml", "-o", folder, "--workers", "1", "-q"]) == 0
    assert {"report.pdf", "map.parquet", "map-stability.png"} <= names(Path(folder))


@pytest.mark.parametrize("name", first(0, ["large.html", "large.pdf"]))
def test_a_page_or_baseline_beyond_reason_is_refused_before_it_is_parsed(name: str, tmp_path: Path, capsys) -> None:
    path = tmp_path / name
    path.write_bytes(b"%PDF-" if name.endswith("pdf") else b"[")
    os.truncate(path, 240 << 20)
    assert main(["run", str(path)]) == 2
    assert "is larger than 64 MiB, and neither" in capsys.readouterr().err
    for command in (["compare", "--exit-code", str(path), INCLINED], ["run", INCLINED, "--baseline", str(path)]):
        assert main(command) == 2
        assert "is larger than 64 MiB, and neither" in capsys.readouterr().err


def test_what_cannot_be_written_is_said_before_the_work(tmp_path: Path, monkeypatch, capsys) -> None:
    from vireport.study import study

    monkeypatch.setattr(study, "solution_of", lambda *arguments: pytest.fail("it worked in vain"))
    (tmp_path / "file").write_text("")
    for command in (["run", INCLINED], ["compare", INCLINED, "--vary", "inclination_deg=1,2"], ["verify", INCLINED]):
        assert main([*command, "-o", str(tmp_path / "file")]) == 2
        assert "cannot be written" in capsys.readouterr().err


@pytest.mark.slow
def test_a_comparison_does_not_overwrite_another(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)

    def compare(angles: str) -> None:
        assert main(["compare", DESIGN, "--vary", f"inclination_deg={angles}", "--format", "json", "-q"]) == 0

    compare("30,45")
    compare("30,45")
    assert names(tmp_path) == {"comparison"}
    first = (tmp_path / "comparison/compare.json").read_bytes()
    compare("30,40")
    compare("20,40")
    assert names(tmp_path) == {"comparison", "comparison-2", "comparison-3"}
    assert (tmp_path / "comparison/compare.json").read_bytes() == first


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "folder"),
    [
        (b"..yaml", b"report"),
        (b".yaml", b".yaml-report"),
        (b"plain", b"plain-report"),
        (b"\xff.yaml", b"\xff"),
        (b"-", b"stdin"),
    ],
)
def test_the_folder_is_named_after_the_scenario(name: bytes, folder: bytes, tmp_path: Path) -> None:
    text = Path(DESIGN).read_bytes()
    if name != b"-":
        Path(os.fsdecode(os.path.join(os.fsencode(tmp_path), name))).write_bytes(text)
    run = subprocess.run(
        [*ENTRY, name, "--format", "json,html" if b"\xff" in name else "json"],
        cwd=tmp_path,
        input=text,
        capture_output=True,
    )
    assert run.returncode == 0, run.stderr
    written = {os.fsencode(path.name) for path in tmp_path.iterdir()} - {name}
    assert written == {folder}
    assert json.loads((tmp_path / os.fsdecode(folder) / "results.json").read_text())["provenance"]["scenario_name"]


def test_an_empty_folder_name_is_refused(capsys) -> None:
    assert main(["run", DESIGN, "-o", "", "--format", "json"]) == 2
    assert "is empty" in capsys.readouterr().err


FORMATS = ["json,csv", pytest.param("html,pdf,png,json,csv", marks=pytest.mark.slow)]


@pytest.mark.slow
@pytest.mark.parametrize("formats", FORMATS)
def test_names_are_text_everywhere(formats: str, tmp_path: Path, capsys) -> None:
    """In messages, figures, tables and pages: no mathematics, command, formula or link comes of a name."""
    traps = ("$\\frac{$", "=1+1", "a\n::error::b", "\x1b[31mred", "中文", "@octocat")
    for name in traps:
        shutil.copy(INCLINED if name in "$\\frac{$中文" else DESIGN, tmp_path / f"{name}.yaml")
    files = [str(tmp_path / f"{name}.yaml") for name in traps]
    assert main(["compare", *files, "-o", str(tmp_path / "out"), "--format", formats]) == 0
    assert main(["run", files[2], "-o", str(tmp_path / "a\n::error::b"), "--format", "markdown,junit,github"]) == 0
    assert main(["check", files[2], "--set", "\x1b[2J::error::=1"]) == 2
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err
    assert not any(line.startswith("::error") for line in (out + err).splitlines())
    table = (tmp_path / "out" / "compare.csv").read_text()
    assert "\n'=1+1," in table
    assert "\n'@octocat," in table


@pytest.mark.parametrize(
    "arguments", [["--\x1b[2J::error::x"], [DESIGN, "a\n::error::b"], [DESIGN, "--templates", "\x1b[2J::error::x"]]
)
def test_arguments_that_are_refused_are_text(arguments: list[str], capsys) -> None:
    assert main(["run", *arguments]) == 2
    out, err = capsys.readouterr()
    assert "\\x3aerror" in err
    assert "::" not in err
    assert "\x1b" not in err
    assert out == ""


def test_checks_say_nothing_where_that_is_asked_for(tmp_path: Path, capsys) -> None:
    assert main(["check", INCLINED, "-q"]) == 0
    assert main(["run", INCLINED, "-o", str(tmp_path), "--format", "json", "-q"]) == 0
    results = str(tmp_path / "results.json")
    assert main(["compare", "--exit-code", results, INCLINED, "-q"]) == 0
    assert main(["compare", "--exit-code", results, INCLINED, "-q", "--set", "device.restitution=0.51"]) == 1
    assert capsys.readouterr() == ("", "")


def test_a_map_is_known_by_every_command(capsys) -> None:
    path = str(ROOT / "examples/maps/map.yaml")
    assert main(["check", path]) == 0
    assert main(["check", path, "--set", "device.restitution=2"]) == 2
    assert "--set device.restitution: got 2, which is too large" in capsys.readouterr().err
    for command in ([], ["run"], ["verify"], ["compare", INCLINED]):
        assert main([*command, path]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "is computed by 'vireport map FILE'" in line


def test_a_plan_promises_nothing_that_will_not_appear(monkeypatch, capsys) -> None:
    assert main(["check", INCLINED, "--set", "accuracy.compliant_membrane=false"]) == 0
    lines = {line.split()[1]: line for line in capsys.readouterr().out.splitlines()[1:]}
    assert "figure-stiffness" not in lines
    monkeypatch.setitem(sys.modules, "numba", None)
    assert main(["check", INCLINED, "--set", "accuracy={}", "--set", "simulation={}"]) == 0
    lines = {line.split()[1]: line for line in capsys.readouterr().out.splitlines()[1:]}
    for step in ("accuracy", "simulation"):
        assert lines[step].startswith("run")
        assert "numba" in lines[step]


def test_a_plan_says_how_long_what_is_long_takes(capsys) -> None:
    best = str(ROOT / "examples" / "best-design.yaml")
    assert main(["check", best, "--set", "accuracy={}"]) == 0
    rows = capsys.readouterr().out.splitlines()[1:]
    assert rows[-1].startswith("The best design, by vireport optimise: about 20 s.")
    lines = {line.split()[1]: line for line in rows}
    assert "about a minute" in lines["accuracy"]
    assert "some ten seconds" in lines["compliant"]
    assert main(["check", best, "--set", "tolerances.length_percent=1"]) == 0
    assert "by vireport optimise: minutes" in capsys.readouterr().out


def test_the_limits_in_messages_are_those_that_hold(capsys) -> None:
    assert main(["check", INCLINED, "--set", "accuracy.ladder=[1]"]) == 2
    assert "a list of 1 value (a list of 2 to 8 numbers)" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("settings", [b"\xff\xfe", b"axes.formatter.use_locale: True\n", b"font.size: none\n"])
def test_settings_of_matplotlib_and_a_locale_that_are_broken_have_no_part(settings: bytes, tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").write_bytes(settings)
    broken = {"MATPLOTLIBRC": str(tmp_path), "MPLBACKEND": "nonsense", "LC_ALL": "xx"}
    line = [*ENTRY, "run", DESIGN, "--format", "png", "-q", "-o", str(tmp_path / "out")]
    run = subprocess.run(line, capture_output=True, text=True, env=os.environ | broken, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    assert (tmp_path / "out" / "figure-device.png").is_file()
