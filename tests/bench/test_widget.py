"""The bench in a notebook: messages of the page, and what the kernel sends back."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from typing import Any

import pytest
from conftest import EXAMPLES

import vireport
from vireport.base.errors import ScenarioError, UsageError
from vireport.bench.notebook import explore
from vireport.bench.session import first, opened
from vireport.bench.widget import BenchWidget
from vireport.scenario.loading import load


def encoded(answer: dict[str, Any]) -> Any:
    """An answer as a page has it."""
    return json.loads(json.dumps(answer))


class Page:
    """What the page of a widget sends and hears."""

    def __init__(self, widget: BenchWidget) -> None:
        self.widget, self.heard = widget, list[dict[str, Any]]()
        widget.send = self.heard.append

    def ask(self, number: int, kind: str, state: dict[str, Any]) -> None:
        self.widget._heard(self.widget, {"number": number, "kind": kind, "question": {"state": state}}, [])

    def answer(self, number: int) -> Any:
        until = time.monotonic() + 60
        while time.monotonic() < until:
            for told in list(self.heard):
                if told["number"] == number and "answer" in told:
                    return told["answer"]
            time.sleep(0.02)
        raise AssertionError("there is no answer")


@pytest.fixture
def page() -> Iterator[Page]:
    widget = vireport.explore(EXAMPLES / "inclined.yaml")
    yield Page(widget)
    widget.close()


@pytest.mark.slow
def test_questions_are_answered_by_their_number(page: Page) -> None:
    page.ask(1, "first", {"device.length_m": 0.7})
    page.ask(2, "study", {"device.length_m": 0.6})
    page.ask(3, "first", {"device.length_m": -1.0})
    assert page.answer(1) == encoded(first(opened(EXAMPLES / "inclined.yaml"), {"device.length_m": 0.7}))
    assert page.answer(2)["verdict"]["sentence"] == "It does not run: no 1:1 motion is stable."
    assert page.answer(3)["refused"][0]["path"] == "device.length_m"


def test_the_scenario_is_that_of_the_page(page: Page) -> None:
    assert page.widget.loaded.scenario.device.length_m == 0.6934
    page.widget.state = {"device.length_m": 0.71}
    assert page.widget.loaded.scenario.device.length_m == 0.71
    page.widget.state = {"device.length_m": -1.0}
    with pytest.raises(ScenarioError, match="length_m"):
        _ = page.widget.loaded


def test_a_study_and_what_was_loaded_can_be_shown() -> None:
    loaded = load(EXAMPLES / "inclined.yaml", {"device.length_m": 0.7})
    for source in (loaded, vireport.analyse(loaded, ())):
        widget = explore(source)
        assert widget.loaded.scenario.device.length_m == 0.7
        widget.close()


def test_what_is_missing_is_named_with_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vireport.bench.notebook.find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"needs the package anywidget: pip install 'vireport\[notebook\]'"):
        explore(EXAMPLES / "inclined.yaml")


def test_a_file_that_there_is_not_is_refused() -> None:
    with pytest.raises(UsageError, match="no such file"):
        explore("nowhere.yaml")
