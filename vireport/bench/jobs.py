"""What processes beside the server answer: margins, and what takes long, which is ended where a page has moved on."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from enum import StrEnum
from typing import Any

import msgspec
from msgspec import Struct

from vireport.base.reading import ReadingPlace

PATIENCE = 0.5
"""How long a job that nobody waits for any more may go on before its process is ended [s]: to begin one takes as
long."""


class Aside(StrEnum):
    """What a page asks that another process answers: margins beside the curves, and the rest when the hand rests."""

    MARGINS = "margins"
    PLANE = "plane"
    STUDY = "study"
    CHANGES = "changes"


Axes = tuple[str, str]
Ranges = tuple[tuple[float, float], tuple[float, float]]


class Asked(Struct, frozen=True):
    """A question of a page to the bench: the state of its sliders, and what is wanted.

    Attributes
    ----------
    state : dict
        Values that replace those of the scenario, by their paths.
    page : str
        Which page asks, where there may be several.
    axes, ranges
        Of the plane, see `answers.plane_answer`; of other questions nothing.
    name : str
        Of a file to save; of other questions nothing.
    """

    state: dict[str, Any]
    page: str = ""
    axes: Axes = ("", "")
    ranges: Ranges = ((0.0, 0.0), (0.0, 0.0))
    name: str = ""


class Job(Struct, frozen=True):
    """A question about a scenario, for the process that answers it.

    Attributes
    ----------
    kind : Aside
    text, name : str
        Of the scenario.
    overrides : tuple of str
    place : ReadingPlace
        Where the records that it names are looked for.
    axes, ranges
        As in the question.
    """

    kind: Aside
    text: str
    name: str
    overrides: tuple[str, ...]
    place: ReadingPlace
    axes: Axes
    ranges: Ranges

    def same_scenario(self, other: Job) -> bool:
        """Whether another job is about the same scenario."""
        return (self.text, self.name, self.overrides) == (other.text, other.name, other.overrides)


class Worker:
    """A process that answers jobs, one at a time."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._since: float | None = None
        self._count = 0
        self._beginning = threading.Lock()
        self._ended = False
        self._process = _begun()

    def answers(self, job: Job) -> Iterator[dict[str, Any]]:
        """Give ``progress`` as it comes and then the ``answer``, and end the job before if that takes long.

        There is no answer where the process was ended.

        Raises
        ------
        RuntimeError
            If the process has failed, which is a fault of ours.
        """
        while not self._turn.acquire(timeout=PATIENCE / 5):
            self.drop()
        try:
            yield from self._messages(job)
        finally:
            self._since = None
            self._turn.release()
            self._close_if_ended()

    def answer(self, job: Job) -> dict[str, Any] | None:
        """The answer to a job that ends none before it; None where the process was ended. Raises as `answers`."""
        try:
            with self._turn:
                return next((answer["answer"] for answer in self._messages(job) if "answer" in answer), None)
        finally:
            self._close_if_ended()

    def _messages(self, job: Job) -> Iterator[dict[str, Any]]:
        process, number = self._running(), self._count + 1
        if process is None:
            return
        self._since, self._count = time.monotonic(), number
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(BrokenPipeError):  # it was ended before
            process.stdin.write(f"{number} {msgspec.json.encode(job).decode()}\n")
            process.stdin.flush()
        for line in process.stdout:
            of, _, line_data = line.partition(" ")
            if int(of) != number:
                continue  # of a job before, whose page has gone
            answer = json.loads(line_data)
            yield answer
            if "answer" in answer:
                return
        with process:  # which has ended: its streams are closed
            failed = process.wait() > 0
        if failed:
            raise RuntimeError("the process that answers has failed")
        self._running()  # ahead of the next job

    def _running(self) -> subprocess.Popen[str] | None:
        """The process, another one where it has ended; None where there is to be none any more."""
        with self._beginning:
            if self._ended:
                return None
            if self._process.poll() is not None:
                _close(self._process)
                self._process = _begun()
            return self._process

    def drop(self) -> None:
        """End the process if a job keeps it busy that is of no use any more."""
        since = self._since
        if since is not None and time.monotonic() - since > PATIENCE:
            self._process.kill()

    def end(self) -> None:
        """End the process, and begin none any more."""
        with self._beginning:
            self._ended = True
        self._process.kill()
        self._process.wait()
        self._close_if_ended()

    def _close_if_ended(self) -> None:
        """Close the streams of a process that was ended, unless they are being read: who reads them calls this too."""
        if self._ended and self._turn.acquire(blocking=False):
            _close(self._process)
            self._turn.release()


def _close(process: subprocess.Popen[str]) -> None:
    """Close the streams of a process that has ended, also where it has not read what it was sent."""
    with suppress(OSError), process:
        pass


def _begun() -> subprocess.Popen[str]:
    # In a session of its own: Ctrl-C is for the server, which then ends it.
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "vireport.bench"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )
