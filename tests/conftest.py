"""What the tests share: the examples, and results computed once."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from browser import Browser
from hypothesis import settings

if TYPE_CHECKING:
    from vireport.design import Margins, Solution
    from vireport.motions import Motions
    from vireport.physics import Device
    from vireport.study import Study

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
NAMES = ("horizontal", "inclined", "inclined-forcing", "design-point")


def first(count: int, cases: Iterable[Any]) -> list[Any]:
    """Mark all cases but the first ones as slow."""
    slow = (pytest.mark.slow,)
    return [case if k < count else pytest.param(case, marks=slow) for k, case in enumerate(cases)]


def sentences(text: str) -> int:
    """How many sentences a caption has."""
    return len(re.findall(r"\.(?= |$)", text))


@cache
def study(name: str, *overrides: str) -> Study:
    """Study of an example, with overrides, computed once."""
    from vireport import analyse, load

    return analyse(load(EXAMPLES / f"{name}.yaml", overrides))


@cache
def solved(name: str, **over: object) -> Solution:
    """Solution of an example, with overrides, `__` for the dots of their paths."""
    from vireport import analyse, load

    given = {path.replace("__", "."): value for path, value in over.items()}
    return analyse(load(EXAMPLES / f"{name}.yaml", given), ("json",)).solution


def toleranced(**over: object) -> Solution:
    """Solution of the inclined example, with overrides as in `solved`, without a proof over its tolerances."""
    from vireport import load
    from vireport.design import solution_of
    from vireport.physics import Device, Membrane
    from vireport.study import sweep_of

    given = {path.replace("__", "."): value for path, value in over.items()}
    scenario = load(EXAMPLES / "inclined.yaml", given).scenario
    known = Membrane.of(scenario), sweep_of(scenario), scenario.value_of(scenario.parameter) is not None
    return solution_of(Device.of(scenario), *known, scenario.tolerances)


def markdown(study: Study, command: str) -> str:
    """The summary of a study as Markdown."""
    from vireport.report import Report, render_markdown
    from vireport.study import provenance_of

    report = Report(study, {}, provenance_of(study.loaded, command), template="summary.typ.j2")
    return render_markdown(report).decode()


settings.register_profile("default", derandomize=True, deadline=None)
settings.load_profile("default")
# Colours forced by a CI system must not get into the messages that tests read.
os.environ.update(TERM="dumb", NO_COLOR="1", COLUMNS="100")


@pytest.fixture(scope="session", autouse=True)
def known_ends() -> Iterator[None]:
    """The ends of a device's stable motions are looked for once: hundreds of tests analyse the same few devices."""
    from vireport.design import point

    search, known = point.margins_of, {}

    def margins_of(device: Device, motions: Motions, *along: Any) -> Margins:
        if along:
            return search(device, motions, *along)
        key = device, motions.d.tobytes(), motions.velocity_bottom.tobytes(), motions.stability.tobytes()
        if key not in known:
            known[key] = search(device, motions)
        return known[key]

    point.margins_of = margins_of
    yield
    point.margins_of = search


@pytest.fixture(scope="session")
def example() -> Callable[[str], Path]:
    """Path of an example scenario by its name."""
    return lambda name: EXAMPLES / f"{name}.yaml"


@pytest.fixture(scope="session")
def study_of() -> Callable[..., Study]:
    """Study of an example, computed once."""
    return study


@pytest.fixture
def without_a_front(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search does not ask what larger margins cost, which takes nine tenths of it."""
    monkeypatch.setattr("vireport.optimise.search.LEVELS", ())


@pytest.fixture
def short_front(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search asks for three margins only what they cost."""
    monkeypatch.setattr("vireport.optimise.search.LEVELS", (0.05, 0.14, 0.28))


@pytest.fixture(scope="module")
def forty_digits() -> Iterator[None]:
    """The 40 digits of the reference, also for what a test works out itself."""
    from vireport.checks import reference

    with reference.precise():
        yield


@pytest.fixture(scope="module")
def browser(folder: Path) -> Iterator[Browser]:
    """The page that a module's `folder` holds, in Chromium."""
    browser = Browser(folder / "profile")
    browser.open(folder / "report.html")
    yield browser
    browser.close()
