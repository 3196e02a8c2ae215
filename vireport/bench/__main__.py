"""A process that answers beside the server: a job a line of JSON on standard input, answers on the output.

Margins come from one, at the same time as the curves. What takes long comes from another, so that a hand that moves on
need not wait for it: it is ended, and another one begun.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator

import msgspec
from msgspec import Struct, to_builtins

from vireport.base.encoding import json_text
from vireport.base.errors import VireportError
from vireport.bench.answers import margins_answer, plane_answer, study_answer
from vireport.bench.changes import changes
from vireport.bench.jobs import Aside, Job
from vireport.bench.session import refusal
from vireport.scenario.loading import loads
from vireport.study.plan import Task
from vireport.study.study import Study, analyse


class _Last(Struct, frozen=True):
    """The study that was made last: what to change is asked for after it."""

    job: Job
    study: Study


def _answers(lines: Iterator[str], write: Callable[[str, dict[str, object]], None]) -> None:
    last: _Last | None = None
    for line in lines:
        number, _, question = line.partition(" ")
        job = msgspec.json.decode(question, type=Job)

        def say(what: str, number: str = number) -> None:
            write(number, {"progress": what})

        try:
            if job.kind is Aside.MARGINS:
                answer = margins_answer(loads(job.text, job.name, job.overrides, job.place))
            elif job.kind is Aside.PLANE:
                answer = plane_answer(loads(job.text, job.name, job.overrides, job.place), job.axes, job.ranges)
            else:
                if last is None or not last.job.same_scenario(job):
                    loaded = loads(job.text, job.name, job.overrides, job.place)
                    last = _Last(job, analyse(loaded, (Task.JSON,), say))
                if job.kind is Aside.STUDY:
                    answer = study_answer(last.study)
                else:
                    answer = {"changes": to_builtins(changes(last.study, say))}
        except VireportError as error:
            answer = refusal(error)
        write(number, {"answer": answer})


def main() -> None:
    """Answer until standard input ends."""
    # What a library may print on standard output would be taken for an answer.
    output = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def write(number: str, answer: dict[str, object]) -> None:
        output.write(f"{number} {json_text(answer)}\n")
        output.flush()

    _answers(iter(sys.stdin.readline, ""), write)


if __name__ == "__main__":
    main()
