"""Names that commands had go on working: what they print, write and end with is that of the new ones."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from vireport.cli.app import main, program
from vireport.cli.group import OLD_NAMES

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
MAP = str(EXAMPLES / "maps" / "map.yaml")
INCLINED = str(EXAMPLES / "inclined.yaml")
CHANGED = [INCLINED, "--set", "device.restitution=0.51"]
CHART = [
    INCLINED,
    "--over",
    "inclination_deg=40..50,length_m=0.6..0.7",
    "--format",
    "json",
    "--set",
    "motions.impacts=2",
]

SAME = {
    "validate": ([INCLINED], ["check", INCLINED], 0),
    "validate what is none": ([*CHANGED, "--set", "lenght=1"], ["check", *CHANGED, "--set", "lenght=1"], 2),
    "plan": ([INCLINED, "--json", "--format", "csv"], ["check", INCLINED, "--json", "--format", "csv"], 0),
    "schema": ([], ["init", "--schema"], 0),
    "diff": (["../old.json", INCLINED], ["compare", "../old.json", INCLINED, "--exit-code"], 0),
    "diff of another": (["../old.json", *CHANGED, "--markdown"],
                        ["compare", "../old.json", *CHANGED, "--markdown", "--exit-code"], 1),
    "accuracy": ([INCLINED, "-o", "out"], ["verify", INCLINED, "-o", "out"], 0),
    "extremes": (["--json"], ["verify", "--extremes", "--json"], 0),
    "extremes of a map": ([MAP], ["verify", MAP, "--extremes"], 2),
    "sweep": (["../map.yaml", "--workers", "1"], ["map", "../map.yaml", "--workers", "1"], 0),
    "chart": (CHART, ["map", *CHART], 0),
}  # fmt: skip
SAME = {name: case for name, case in SAME.items() if case[1][0] in program().commands}
SLOW = ("sweep", "chart")


@pytest.fixture
def place(tmp_path: Path, study_of, monkeypatch) -> Path:
    """A folder with an earlier run and a map; what is measured takes no time, and one extreme case is run."""
    from vireport.verify import catalogue, outputs
    from vireport.verify.rows import Case, CaseFinding

    row = Case("test", "made up", lambda: CaseFinding(""))
    monkeypatch.setattr(catalogue, "catalogue", lambda loaded=None: (row,))
    monkeypatch.setattr(outputs, "measured_study", lambda *_: study_of("inclined"))
    assert main(["run", INCLINED, "-o", str(tmp_path), "--format", "json", "-q"]) == 0
    (tmp_path / "results.json").rename(tmp_path / "old.json")
    text = (EXAMPLES / "maps/map.yaml").read_text().replace("count: 60", "count: 3").replace("count: 80", "count: 3")
    (tmp_path / "map.yaml").write_text(text)
    return tmp_path


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.slow] * (x in SLOW)) for x in SAME])
def test_an_old_name_does_what_the_new_one_does(name: str, place: Path, monkeypatch, capsys) -> None:
    arguments, new, code = SAME[name]
    found = []
    for folder, line in (("old", [name.split()[0], *arguments]), ("new", new)):
        (place / folder).mkdir()
        monkeypatch.chdir(place / folder)
        ended = main(line)
        files = {str(x.relative_to(place / folder)): x.read_bytes() for x in Path.cwd().rglob("*") if x.is_file()}
        found.append((ended, *capsys.readouterr(), files))
    assert found[0] == found[1]
    ended, out, err, files = found[0]
    assert ended == code
    assert files if name in ("accuracy", *SLOW) else not files
    assert out if code < 2 else err


def test_every_old_name_is_tested_and_none_is_listed(capsys) -> None:
    assert {name.split()[0] for name in SAME} == set(OLD_NAMES)
    assert not set(OLD_NAMES) & set(program().commands)
    assert main(["--help"]) == 0
    assert not set(OLD_NAMES) & set(re.findall(r"^  (\w+)  ", capsys.readouterr().out, re.MULTILINE))


def test_what_is_no_command_any_more_says_what_to_write(capsys) -> None:
    assert main(["portrait", "results.json", "--at", "0.62"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "motions.portraits=[BT]" in line
    assert "vireport explore" in line
