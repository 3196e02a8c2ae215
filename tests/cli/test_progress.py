"""What a command that takes long says while it works: steps, the share that is done, the time left, seconds."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from select import select

import pytest

from vireport import load
from vireport.base.errors import UsageError
from vireport.base.progress import WorkStep, counted, portion
from vireport.cli.app import main
from vireport.cli.outcome import progress
from vireport.identify import outputs as identify_outputs
from vireport.map.chart.over import chart_of
from vireport.verify.catalogue import run_catalogue

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
"""What moves the cursor and sets colours."""


@contextmanager
def on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], str]]:
    """Standard error as a terminal within a test; what it was sent is read by a call."""
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    with monkeypatch.context() as patch, os.fdopen(theirs, "w", encoding="utf-8", buffering=1) as stream:
        patch.setenv("TERM", "xterm")
        patch.delenv("NO_COLOR")
        patch.setattr(sys, "stderr", stream)

        def sent() -> str:
            stream.flush()
            parts, wait = [], 2.0  # the other end may take a moment to have the first of it
            while select([ours], [], [], wait)[0]:
                parts.append(os.read(ours, 65536))
                wait = 0.02
            return b"".join(parts).decode()

        yield sent
    os.close(ours)


def lines(sent: str) -> list[str]:
    return [line for line in re.split(r"[\r\n]+", CONTROL.sub("", sent)) if line.strip()]


def test_a_step_is_text_that_knows_its_share() -> None:
    step = counted("solving", 2, 4)
    assert (step, step.name, step.share, step.number) == ("solving, 2 of 4", "solving", 0.25, "2 of 4")
    assert (WorkStep.of("drawing").share, WorkStep.of(step)) == (None, step)
    told: list[str] = []
    within = portion(portion(told.append, 0.5, 1.0), 0.2, 0.4)
    within(counted("solving", 3, 5))
    within("drawing")
    assert told == ["solving, 3 of 5", "drawing"]
    assert told[0].share == pytest.approx(0.5 + 0.5 * (0.2 + 0.2 * 0.4))
    assert told[1].share is None


@pytest.fixture
def clock(monkeypatch) -> list[float]:
    """The time by which progress is told [s], which stands still until it is set."""
    now = [0.0]
    monkeypatch.setattr("vireport.cli.outcome.perf_counter", lambda: now[0])
    return now


def test_a_terminal_shows_the_share_and_the_time_left(monkeypatch, clock) -> None:
    def last() -> str:
        return " ".join(lines(sent())[-1].split())

    with on_a_terminal(monkeypatch) as sent, progress(False) as say:
        say("reading")
        assert last() == "reading"
        say(counted("solving", 1, 4))
        assert re.fullmatch("solving, 1 of 4 ━+ 0 %", last())
        clock[0] = 30.0
        say(counted("solving", 2, 4))
        assert re.fullmatch("solving, 2 of 4 [━╺╸]+ 25 %, 0:01:30 left", last())
        clock[0] = 40.0
        say("drawing")  # of which no share is known: the last one stands
        assert re.fullmatch("drawing [━╺╸]+ 25 %, 0:02:00 left", last())
        say(WorkStep("long " * 40, 0.999))
        assert re.fullmatch(r"(long )+lo?n?g?…? ?[━╺╸]+ 99 %, 0:00:00 left", last()), last()


def test_time_left_counts_from_what_was_there_before(monkeypatch, clock) -> None:
    """A map of which nine tenths were computed in an earlier run."""
    with on_a_terminal(monkeypatch) as sent, progress(False) as say:
        say(WorkStep("computing cells", 0.9))
        clock[0] = 10.0
        say(WorkStep("computing cells", 0.95))
        assert lines(sent())[-1].rstrip().endswith("95 %, 0:00:10 left")


def test_text_that_is_not_ours_stays_text(monkeypatch) -> None:
    with on_a_terminal(monkeypatch) as sent, progress(False, verbose=True) as say:
        say(WorkStep("[bold]\x1b[31m\nname", 0.5))
        shown = sent()
    assert "[bold]" in shown
    assert "\x1b[31m" not in shown
    assert "\\x1b[31m\\nname" in shown


def test_without_a_terminal_only_the_verbose_write(clock, capsys) -> None:
    def work(say: Callable[[str], None]) -> None:
        say(counted("solving", 1, 2))
        clock[0] += 1.5
        say(counted("solving", 2, 2))
        clock[0] += 0.25
        say("drawing")
        clock[0] += 2.0

    with progress(False) as say:
        work(say)
    with progress(True) as say:
        work(say)
    assert capsys.readouterr() == ("", "")
    with progress(False, verbose=True) as say:
        work(say)
    assert capsys.readouterr().err == "    1.75 s  solving\n    2.00 s  drawing\n    3.75 s  in all\n"


def test_a_terminal_shows_the_seconds_above_the_line(monkeypatch, clock) -> None:
    with on_a_terminal(monkeypatch) as sent, progress(False, verbose=True) as say:
        say("solving")
        clock[0] = 2.0
        say("drawing")
        shown = [line.strip() for line in lines(sent())]
        assert shown.index("2.00 s  solving") < shown.index("drawing")


def test_quiet_and_verbose_exclude_each_other(example, capsys) -> None:
    with pytest.raises(UsageError, match="--quiet and --verbose: one of them"), progress(True, verbose=True):
        pass
    assert main(["run", str(example("inclined")), "--json", "-q", "-v"]) == 2
    assert capsys.readouterr().out == ""


def test_results_stay_alone_on_standard_output(example, capsys) -> None:
    assert main(["run", str(example("design-point")), "--json", "--verbose"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["schema_version"] == 1
    assert re.search(r"^ +\d+\.\d\d s  solving for the 1:1 motions$", err, re.MULTILINE)
    assert re.search(r"^ +\d+\.\d\d s  in all$", err, re.MULTILINE)


def shares(told: list[str]) -> list[float]:
    known = [step.share for step in told if isinstance(step, WorkStep) and step.share is not None]
    assert known[0] == 0.0
    assert known == sorted(known)
    assert known[-1] < 1
    return known


@pytest.mark.slow
@pytest.mark.parametrize("source", [{"impacts": "measured-impacts.csv"}, {"signals": "records/prototype.wav"}])
def test_identify_tells_its_share(source: dict[str, str], example) -> None:
    files = {key: str(EXAMPLES / name) for key, name in source.items()}
    request = identify_outputs.Request(load(example("measured")), **files, referenced="impacts" in source)
    told: list[str] = []
    identify_outputs.outcome(request, identify_outputs.Pages(json=True), told.append)
    assert len(shares(told)) >= 4


@pytest.mark.slow
def test_a_chart_tells_its_share(example) -> None:
    for over in ("inclination_deg=40..50,length_m=0.5..0.8", "restitution_bottom=0.4..0.5,restitution_top=0.4..0.5"):
        told: list[str] = []
        chart_of(load(example("inclined"), {"motions.impacts": 2}), over, told.append)
        assert any(text.startswith("stable motions of the regions, 2 of ") for text in told)
        assert len(set(shares(told))) > 10


@pytest.mark.slow
def test_an_accuracy_study_tells_its_share(example, monkeypatch) -> None:
    from vireport.findings.accuracy import workprecision
    from vireport.verify.outputs import measured_study

    monkeypatch.setattr(workprecision, "METHODS", workprecision.METHODS[:2])
    told: list[str] = []
    measured_study(load(example("inclined"), {"accuracy.repeats": 2, "accuracy.ladder": [1.0, 100.0]}), told.append)
    known = shares(told)
    assert "accuracy: run times, 2 of 2" in told
    assert known[-1] > 0.75


@pytest.mark.slow
def test_extremes_tell_their_share(monkeypatch) -> None:
    from vireport.verify import catalogue

    cases = catalogue.catalogue(None)[:3]
    monkeypatch.setattr(catalogue, "catalogue", lambda loaded: cases)
    told: list[str] = []
    run_catalogue(None, told.append)
    assert shares(told) == pytest.approx([0, 1 / 3, 2 / 3])


def test_a_comparison_tells_its_share(study_of) -> None:
    from vireport import compare

    told: list[str] = []
    compare([study_of("inclined"), study_of("design-point")], progress=told.append)
    assert shares(told) == [0.0, 0.5]
    assert told[1].startswith("solving ")


@pytest.mark.slow
def test_a_map_tells_its_share(tmp_path: Path, capsys) -> None:
    pytest.importorskip("pyarrow")
    text = (
        (EXAMPLES / "maps" / "map.yaml").read_text().replace("count: 60", "count: 5").replace("count: 80", "count: 4")
    )
    (tmp_path / "map.yaml").write_text(text)
    assert main(["map", str(tmp_path / "map.yaml"), "-o", str(tmp_path / "m"), "-v", "--no-figures"]) == 0
    assert re.match(r" +\d+\.\d\d s  computing cells\n", capsys.readouterr().err)
