"""The bench in a cell of a notebook: the same page, whose questions are messages to the kernel."""

from __future__ import annotations

import re
import threading
from contextlib import suppress
from typing import Any

import anywidget
import msgspec
import traitlets

from vireport.base.encoding import json_answer
from vireport.base.errors import VireportError
from vireport.bench.jobs import Aside, Asked, Worker
from vireport.bench.session import MODULES, Opened, first, job_of, loaded_of, refusal, start_data
from vireport.scenario.loading import Loaded
from vireport.text.folders import TEMPLATES


def _read(*names: str) -> str:
    return "\n".join((TEMPLATES / name).read_text(encoding="utf-8") for name in names)


def one_module() -> str:
    """The modules of the page and the one that speaks to a notebook, as one: a widget has no place for several."""
    drawn = re.sub(r"^(import .*$|export (?!default))", "", _read(*(f"bench/{name}" for name in MODULES)), flags=re.M)
    return f"{drawn}\n{_read('bench/widget.js')}"


class BenchWidget(anywidget.AnyWidget):
    """A scenario that is changed by hand; what it has become is `loaded`.

    Attributes
    ----------
    state : dict
        Values that replace those of the scenario, by their paths.
    """

    _esm = one_module()
    _css = _read("_colors.css", "bench/bench.css")
    start = traitlets.Dict().tag(sync=True)
    state = traitlets.Dict().tag(sync=True)

    def __init__(self, session: Opened) -> None:
        super().__init__(start=start_data(session))
        self._opened, self._worker, self._margins_worker = session, Worker(), Worker()
        self.on_msg(self._heard)

    @property
    def loaded(self) -> Loaded:
        """The scenario as it is on the bench, for `vireport.analyse`.

        Raises
        ------
        ScenarioError
            Where what is set makes no scenario.
        """
        return loaded_of(self._opened, self.state)

    def close(self) -> None:
        """End the processes that answer beside the kernel, and take the bench off the page."""
        self._worker.end()
        self._margins_worker.end()
        super().close()

    def _heard(self, _: object, content: dict[str, Any], buffers: object) -> None:
        number, kind = content["number"], content["kind"]
        question = msgspec.convert(content["question"], Asked)
        if kind in set(Aside):
            worker = self._margins_worker if kind == Aside.MARGINS else self._worker
            threading.Thread(target=self._aside, args=(worker, number, Aside(kind), question), daemon=True).start()
            return
        self._worker.drop()
        try:
            answer = first(self._opened, question.state)
        except VireportError as error:
            answer = refusal(error)
        # As JSON that is finite: a notebook would send an infinity on, which no browser reads.
        self.send({"number": number, "answer": msgspec.json.decode(json_answer(answer))})

    def _aside(self, worker: Worker, number: int, kind: Aside, question: Asked) -> None:
        job = job_of(self._opened, kind, question)
        with suppress(RuntimeError):  # whose traceback the process has printed
            for answer in worker.answers(job):
                self.send({"number": number, **answer})
                if "answer" in answer:
                    return
        self.send({"number": number, "answer": None})
