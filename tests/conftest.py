"""What the tests share: the examples, and results computed once."""

from __future__ import annotations

import os
import pickle
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import TYPE_CHECKING, Any

import pytest
from browser import Browser
from hypothesis import settings

from vireport.base.additions import ADDITIONS, ROWS
from vireport.base.errors import ScenarioError

if TYPE_CHECKING:
    from vireport.design.solution import Solution
    from vireport.study.study import Study

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"

KEYS_OF_PAGE = (EXAMPLES.parent / "docs" / "scenario.md").read_text(encoding="utf-8")
"""The page that lists every key of a scenario, also those of additions that are taken out."""

SHORTEST = "{minimise: length_m, cells: 16, vary: [{path: device.length_m, from: 0.6, to: 1.0}]}"
"""A search that takes a second: over one input, bounded by the margin alone."""

WITHOUT = "{margin_any_percent: 5, reached_from_rest: false, field_at_most_percent: 1.0e+9}"
LONGEST_QUICK = 0.3
"""Processor time above which a test is not a quick one [s]: twice what CONTRIBUTING asks, as machines differ."""

OF_ADDITIONS = {
    "motions/atlas/test_given_words.py": {"map"},
    "cli": {
        "certificates",
        "checks",
        "compare",
        "explore",
        "identify",
        "map",
        "membranes",
        "optimise",
        "outcomes",
        "verify",
    },
    "cli/test_readme.py": {"driven", "escape", "proofs", "tolerances"},
    "comparison/test_compare.py": {"outcomes"},
    "figures/test_figures_for_papers.py": {"compare", "map", "optimise"},
    "figures/test_readable_figures.py": {"checks", "compare", "map", "membranes"},
    "bench/test_changes.py": {"outcomes"},
    "bench/test_server.py": {"driven"},
    "bench/test_session.py": {"driven"},
    "study/judging/test_alerts.py": {"driven"},
    "map/cells/test_map_evaluation.py": {"outcomes"},
    "map/cells/test_map_report.py": {"outcomes"},
    "measurement/test_records.py": {"identify"},
    "measurement/test_signals.py": {"identify", "tolerances"},
    "report/test_in_a_browser.py": {"compare", "identify", "map", "optimise"},
    "scenario/test_bad_scenarios.py": {"checks", "outcomes", "tolerances"},
    "scenario/test_schema.py": {"checks", "escape", "membranes", "outcomes", "tolerances"},
    "simulation/test_impacts_by_speed.py": {"outcomes"},
    "study/test_in_python.py": {"compare", "driven", "outcomes", "tolerances"},
    "study/test_refused.py": {
        "certificates",
        "checks",
        "map",
        "membranes",
        "optimise",
        "outcomes",
        "tolerances",
        "verify",
    },
    "study/test_runs_along_a_restitution.py": {"certificates"},
    "study/test_runs_with_falling_restitution.py": {"checks"},
    "study/test_runs_with_harmonics.py": {"tolerances"},
    "test_read_back.py": set(ROWS),
    "test_shown.py": {"compare", "map", "optimise", "outcomes", "proofs", "tolerances"},
    "test_shown_digits.py": {"tolerances"},
    "text/test_words.py": {"compare", "identify", "map"},
}
"""Tests of several rooms at once, with the additions that they need."""

collect_ignore = [file for file, additions in OF_ADDITIONS.items() if not additions <= set(ADDITIONS)]

NAMES = ("horizontal", "inclined", "inclined-forcing", "design-point")


def first(count: int, cases: Iterable[Any], unpacked: bool = False) -> list[Any]:
    """Mark all cases but the first ones as slow; unpacked are those of several parameters."""

    def slow(case: Any) -> Any:
        return pytest.param(*(case if unpacked else (case,)), marks=pytest.mark.slow)

    return [case if k < count else slow(case) for k, case in enumerate(cases)]


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
    from vireport.design.solution import solution_of, with_tolerances
    from vireport.physics.device import Device
    from vireport.physics.energy import Membrane
    from vireport.study.study import sweep_of

    given = {path.replace("__", "."): value for path, value in over.items()}
    scenario = load(EXAMPLES / "inclined.yaml", given).scenario
    known = Membrane.of(scenario), sweep_of(scenario), scenario.value_of(scenario.parameter) is not None
    solution = solution_of(Device.of(scenario), *known)
    return solution if scenario.tolerances is None else with_tolerances(solution, scenario.tolerances)


def markdown(study: Study, command: str) -> str:
    """The summary of a study as Markdown."""
    from vireport.report.context import Report
    from vireport.report.rendering import render_markdown
    from vireport.study.provenance import provenance_of

    report = Report(study, {}, provenance_of(study.loaded, command), template="summary.md.j2")
    return render_markdown(report).decode()


settings.register_profile("default", derandomize=True, deadline=None)
settings.load_profile("default")
# Colours forced by a CI system must not get into the messages that tests read.
os.environ.update(TERM="dumb", NO_COLOR="1", COLUMNS="100")


KNOWN = (
    ("vireport.study.study", "solution_of"),
    ("vireport.design.solution", "design_point"),
    ("vireport.design.solution", "solve"),
    ("vireport.design.point", "margins_of"),
    ("vireport.design.point", "distortions"),
    ("vireport.study.study", "shifts"),
    ("vireport.design.switched_on", "switched_on_at_once"),
    ("vireport.findings.outcomes.outcomes", "switched_on_by"),
    ("vireport.design.compliant.own_stiffness", "own_stiffness"),
    ("vireport.findings.outcomes.withstood", "withstood_by"),
    ("vireport.findings.tolerances.tolerances", "assess_tolerances"),
)
"""Pure functions that hundreds of tests have called with the same few devices, where they are called."""


class Known:
    """Answers of a pure function, each worked out once for equal arguments."""

    asked = True
    """Whether known answers are given: not where a test may have changed what they are worked out by."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function, self.answers = function, dict[bytes, Any]()

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        if not Known.asked:
            return self.function(*arguments, **named)
        key = pickle.dumps((arguments, named))
        if key not in self.answers:
            self.answers[key] = self.function(*arguments, **named)
        return self.answers[key]


@pytest.fixture(scope="session", autouse=True)
def known() -> Iterator[None]:
    """What is found out about a device is found out once: hundreds of tests analyse the same few."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in KNOWN:
            if find_spec(module.rpartition(".")[0]) is None:
                continue  # of an addition that is taken out
            patch.setattr(f"{module}.{name}", Known(getattr(import_module(module), name)))
        yield


def pytest_sessionstart(session: pytest.Session) -> None:
    """Let every second worker import the tests from their other end.

    In a fresh clone all modules are yet to be compiled, which takes half a minute: so each is compiled by one worker.
    """
    worker = getattr(session.config, "workerinput", {}).get("workerid", "gw0")
    if int(worker.removeprefix("gw")) % 2:
        folders = {Path(argument) for argument in session.config.args if Path(argument).is_dir()}
        for file in sorted((file for folder in folders for file in folder.rglob("test_*.py")), reverse=True):
            sys.path[:0] = [str(file.parent)] if str(file.parent) not in sys.path else []
            with suppress(Exception, pytest.skip.Exception):  # which are told when it is collected
                import_module(file.stem)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let a test that puts something in another's place have everything worked out by what it has put there."""
    Known.asked = "monkeypatch" not in getattr(item, "fixturenames", ())


def skip_without_addition(error: ScenarioError) -> None:
    """Skip a test whose scenario has a key of an addition that is taken out, see `tools/take_out.py`."""
    unknown = re.findall(r"(\S+): unknown key", str(error))
    if any(f"`{path}" in KEYS_OF_PAGE for path in unknown):
        pytest.skip("an addition is taken out")


def processor_seconds() -> float:
    """Processor time of this process and of those that it has waited for [s]."""
    return sum(sum(getrusage(who)[:2]) for who in (RUSAGE_SELF, RUSAGE_CHILDREN))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Note the processor time of a test, without its fixtures, in its report."""
    begun = processor_seconds()
    try:
        yield
    except ScenarioError as error:
        skip_without_addition(error)
        raise
    item.user_properties.append(("processor_seconds", processor_seconds() - begun))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Name the quick tests that should be marked as slow."""
    reports = [report for report in terminalreporter.getreports("passed") if "slow" not in report.keywords]
    times = {report.nodeid: dict(report.user_properties).get("processor_seconds", 0.0) for report in reports}
    long = sorted((seconds, test) for test, seconds in times.items() if seconds > LONGEST_QUICK)
    for seconds, test in long:
        terminalreporter.write_line(f"{seconds:5.1f} s of processor time, to be marked as slow: {test}")


@pytest.fixture(scope="session")
def example() -> Callable[[str], Path]:
    """Path of an example scenario by its name."""
    return lambda name: EXAMPLES / f"{name}.yaml"


@pytest.fixture(scope="session")
def study_of() -> Callable[..., Study]:
    """Study of an example, computed once."""
    return study


@pytest.fixture
def without_a_front() -> Iterator[None]:
    """A search does not ask what larger margins cost, which takes nine tenths of it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vireport.optimise.search.LEVELS", ())
        yield


@pytest.fixture
def short_front() -> Iterator[None]:
    """A search asks for three margins only what they cost."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vireport.optimise.search.LEVELS", (0.05, 0.14, 0.28))
        yield


@pytest.fixture(scope="module")
def forty_digits() -> Iterator[None]:
    """The 40 digits of the reference, also for what a test works out itself."""
    from vireport.study.checks import reference

    with reference.precise():
        yield


@pytest.fixture(scope="module")
def browser(folder: Path) -> Iterator[Browser]:
    """The page that a module's `folder` holds, in Chromium."""
    browser = Browser(folder / "profile")
    browser.open(folder / "report.html")
    yield browser
    browser.close()
