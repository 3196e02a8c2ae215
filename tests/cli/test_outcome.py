"""What a command comes to: printed, written and said, each on its stream, and the exit code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from vireport.cli.outcome import CommandOutcome, deliver


def test_everything_goes_where_it_belongs(tmp_path: Path, capsys) -> None:
    outcome = CommandOutcome("β\n", "γ\n", {"a.txt": b"1", "b.txt": b"2"}, "done", "not met")
    deliver(outcome, tmp_path / "new" / "folder")
    out, err = capsys.readouterr()
    folder = tmp_path / "new" / "folder"
    assert out == "β\nγ\n"
    assert err == f"done\nwrote {folder}/a.txt, {folder}/b.txt\n"
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == outcome.files


def test_without_files_there_is_no_folder(tmp_path: Path, capsys) -> None:
    deliver(CommandOutcome(b"data", "text"), tmp_path / "folder")
    assert capsys.readouterr() == ("datatext", "")
    deliver(CommandOutcome(b"data", "text"), tmp_path / "folder", quiet=True)
    assert capsys.readouterr() == ("data", "")
    assert not (tmp_path / "folder").exists()


@pytest.mark.parametrize(("summary", "quiet"), [("", False), ("done", True)])
def test_a_failure_is_told_where_the_summary_is_not(summary: str, quiet: bool, capsys) -> None:
    with pytest.raises(typer.Exit) as caught:
        deliver(CommandOutcome(summary=summary, failure="1 of 2 requirements is not met", exit_code=1), quiet=quiet)
    assert caught.value.exit_code == 1
    assert capsys.readouterr().err == "vireport: 1 of 2 requirements is not met\n"


@pytest.mark.slow
def test_steps_are_shown_on_a_terminal_and_nothing_is_left_of_them(example, tmp_path: Path) -> None:
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "vireport", str(example("design-point")), "-o", str(tmp_path), "--format", "json"]
    environment = {**os.environ, "TERM": "xterm"}
    process = subprocess.Popen(command, stderr=theirs, stdout=subprocess.PIPE, env=environment)
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert process.communicate()[0].startswith(b"It runs, and starts by itself")
    assert process.returncode == 0
    steps, erased, summary = shown.rpartition(b"\x1b[2K")
    assert b"solving" in steps
    assert erased
    assert b"solving" not in summary
    assert b"wrote" in summary
