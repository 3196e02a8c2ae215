"""What a command does where a file is in the place of one that it would write: ours are replaced, others are not."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from vireport.base import files
from vireport.base.errors import UsageError
from vireport.base.files import is_marked, require_writable
from vireport.cli.app import main

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
DESIGN, INCLINED = str(EXAMPLES / "design-point.yaml"), str(EXAMPLES / "inclined.yaml")
MINE = b"what a user has written\n"

LINES = {
    "run": (["run", DESIGN], "report.html"),
    "no command": ([DESIGN, "--format", "json"], "results.json"),
    "figures": (["run", DESIGN, "--format", "png"], "figure-margins.png"),
    "one that goes": (["run", DESIGN, "--format", "csv"], "branches.csv"),
    "compare": (["compare", DESIGN, INCLINED], "compare.csv"),
    "chart": (["map", INCLINED, "--over", "length_m,inclination_deg"], "chart.md"),
    "sweep": (["map", str(EXAMPLES / "maps" / "map.yaml")], "map-margin.png"),
    "optimise": (["optimise", str(EXAMPLES / "best-design.yaml"), "--format", "png"], "best.yaml"),
    "identify": (["identify", DESIGN, "--impacts", str(EXAMPLES / "measured-impacts.csv")], "impacts.csv"),
    "accuracy": (["verify", DESIGN], "accuracy.json"),
}
"""Commands, and a file that each may write or remove."""


@pytest.mark.parametrize("case", LINES)
def test_what_is_not_ours_is_never_replaced_unasked(case: str, tmp_path: Path, capsys) -> None:
    line, name = LINES[case]
    (tmp_path / name).write_bytes(MINE)
    assert main([*line, "-o", str(tmp_path)]) == 2
    printed, said = capsys.readouterr()
    assert printed == ""
    assert said.startswith(f"vireport: error: {tmp_path} holds {name}, which vireport did not write")
    assert "-o" in said
    assert "--force" in said
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [(name, MINE)]


def test_it_is_refused_before_any_work(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("vireport.cli.outputs.analyse", lambda *_: pytest.fail("work was done"))
    for name in ("report.html", "report.pdf", "results.json"):
        (tmp_path / name).write_bytes(MINE)
    assert main(["run", DESIGN, "-o", str(tmp_path)]) == 2
    assert "report.html, report.pdf, results.json, which" in capsys.readouterr().err


def test_ours_are_replaced_and_others_stay(tmp_path: Path) -> None:
    line = ["run", INCLINED, "--format", "json,csv", "-q", "-o", str(tmp_path)]
    assert main(line) == 0
    (tmp_path / "notes.txt").write_bytes(MINE)
    (tmp_path / "report.html").write_bytes(MINE)
    before = (tmp_path / "branches.csv").read_bytes()
    assert main([*line, "--set", "device.length_m=0.71"]) == 0
    assert main(["run", DESIGN, "--format", "csv,json", "-q", "-o", str(tmp_path)]) == 0
    assert not (tmp_path / "branches.csv").exists()
    assert before
    assert (tmp_path / "notes.txt").read_bytes() == (tmp_path / "report.html").read_bytes() == MINE


def test_force_replaces_what_is_not_ours(tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text(json.dumps({"schema_version": 1, "mine": True}))
    line = ["run", DESIGN, "--format", "json", "-q", "-o", str(tmp_path)]
    assert main(line) == 2
    assert main([*line, "--force"]) == 0
    assert json.loads((tmp_path / "results.json").read_text())["provenance"]["command"]
    assert main(line) == 0


def every_line(folder: Path) -> Iterator[list[str]]:
    formats = "html,pdf,png,svg,figure-pdf,json,csv,junit,markdown"
    yield ["run", INCLINED, "--set", "tolerances.length_percent=20", "--format", formats]
    yield ["run", INCLINED, "--format", formats, "--templates", str(folder / "plain")]
    yield ["compare", DESIGN, INCLINED, "--format", formats.replace(",junit", "")]
    yield ["map", INCLINED, "--over", "length_m=0.6..0.75,inclination_deg=40..50"]
    yield ["map", str(folder / "map.yaml")]
    yield ["optimise", str(folder / "search.yaml"), "--format", "png,svg,figure-pdf"]
    record = str(EXAMPLES / "measured-impacts.csv")
    yield ["identify", str(EXAMPLES / "measured.yaml"), "--impacts", record, "--clock", "force"]


@pytest.mark.slow
def test_whatever_is_written_says_so(tmp_path: Path) -> None:
    """Of every command and format, a second run replaces what the first has written."""
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / "report.typ.j2").write_text('#set document(title: "x")\n= {{ report.title }}\n')
    text = (EXAMPLES / "maps" / "map.yaml").read_text(encoding="utf-8")
    (tmp_path / "map.yaml").write_text(text.replace("count: 60", "count: 6").replace("count: 80", "count: 8"))
    text = (EXAMPLES / "design-point.yaml").read_text(encoding="utf-8")
    search = "{maximise: velocity_bottom, cells: 16, vary: [{path: device.length_m, from: 0.7, to: 1.1}]}"
    (tmp_path / "search.yaml").write_text(f"{text}\ndesign: {search}\n")
    for k, line in enumerate(every_line(tmp_path)):
        folder = tmp_path / f"out {k}"
        assert main([*line, "-q", "-o", str(folder)]) in (0, 1), line
        written = [path for path in folder.iterdir() if path.is_file() and path.suffix not in (".lock", ".parquet")]
        for path in written:
            known = path.name in files.RECOGNISED_BY or path.name in (".lock", "map.parquet.sha256")
            assert known or is_marked(path.name, path.read_bytes()), (line, path.name)
        assert len(written) >= 3
        require_writable(folder, [path.name for path in written if not path.name.startswith((".", "map.parquet"))])


def test_a_record_is_ours_beside_what_was_identified_from_it(tmp_path: Path) -> None:
    (tmp_path / "impacts.csv").write_text("time_s,membrane,standard_error_s\n")
    with pytest.raises(UsageError, match=r"holds impacts\.csv"):
        require_writable(tmp_path, ["impacts.csv"])
    (tmp_path / "identified.json").write_text('{\n"provenance": {"version": "0.1.0", "scenario_name": "x"}\n}')
    require_writable(tmp_path, ["impacts.csv", "identified.json"])


def test_a_link_is_what_it_leads_to(tmp_path: Path) -> None:
    (tmp_path / "report.html").symlink_to(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"holds report\.html"):
        require_writable(tmp_path, ["report.html"])
