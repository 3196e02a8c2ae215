"""The processes that answer beside the server: none is begun for a page that is not there any more."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable

import pytest

from vireport.base.reading import ReadingPlace
from vireport.bench import jobs
from vireport.bench.jobs import Aside, Job, Worker

JOB = Job(Aside.STUDY, "", "x", (), ReadingPlace(), ("", ""), ((0.0, 0.0), (0.0, 0.0)))

BUSY = """
import sys
for line in sys.stdin:
    print(line.partition(" ")[0], '{"progress": "at it"}', flush=True)
"""
"""A process that is at a job for ever."""


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[str]]:
    processes = list[subprocess.Popen[str]]()

    def begin() -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        processes.append(subprocess.Popen([sys.executable, "-c", BUSY], stdin=pipe, stdout=pipe, encoding="utf-8"))
        return processes[-1]

    monkeypatch.setattr(jobs, "_begun", begin)
    return processes


def test_a_process_that_is_ended_at_work_gives_no_answer_and_is_the_last(begun) -> None:
    worker = Worker()
    answers = worker.answers(JOB)
    assert next(answers) == {"progress": "at it"}
    worker.end()
    assert list(answers) == []
    assert len(begun) == 1
    assert begun[0].poll() is not None
    assert begun[0].stdout.closed


@pytest.mark.parametrize("ask", [lambda worker: list(worker.answers(JOB)), lambda worker: worker.answer(JOB)])
def test_a_question_that_comes_late_begins_none(begun, ask: Callable[[Worker], object]) -> None:
    worker = Worker()
    worker.end()
    assert not ask(worker)
    assert len(begun) == 1


def test_one_that_waits_for_its_turn_begins_none(begun) -> None:
    worker = Worker()
    first = worker.answers(JOB)
    next(first)
    answers = list[object]()
    waiting = threading.Thread(target=lambda: answers.extend(worker.answers(JOB)))
    waiting.start()
    worker.end()
    assert list(first) == []
    waiting.join(30)
    assert not waiting.is_alive()
    assert answers == []
    assert len(begun) == 1


def test_one_that_has_ended_by_itself_is_begun_again(begun) -> None:
    worker = Worker()
    begun[0].kill()
    begun[0].wait()
    assert next(worker.answers(JOB)) == {"progress": "at it"}
    assert len(begun) == 2
    worker.end()
    assert begun[1].poll() is not None
