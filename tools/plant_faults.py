"""Plant the faults of `faults.yaml` one at a time into a copy of the project, and tell which the tests catch.

    python tools/plant_faults.py [--jobs 2] [--only PATTERN] [--calls FILE] [--whole] [--check] [--record]

All quick tests run once without a fault, and what each calls is noted. Of each fault those run first that call the
function, or the macro, in which it is planted, the quickest first; of what survives them, the tests that read pages
back, the quick tests of the files that those before stand in, and at last the slow ones of pages and of the package;
with --whole, all quick tests of what is left. To note the calls takes as long as some hundred faults; the FILE of
--calls keeps them for the next run. With --check no test runs: it tells only which faults have no place, or several, in
their file. Nothing in the working tree is changed, but for `benchmarks/results/faults.json` with --record: the counts
for docs/accuracy.md.

Tests run in a fork of a process that has solved the scenarios of the pages that are read back. What a fault in code or
in a file of patterns can have changed is imported anew; a template is read anew by each report.
"""

from __future__ import annotations

import argparse
import ast
import json
import multiprocessing
import os
import pickle
import re
import shutil
import signal
import sys
import time
from collections import Counter
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import date
from functools import cache
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from types import CodeType, FrameType
from typing import NamedTuple

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / "benchmarks" / "results" / "faults.json"
READ_BACK = "tests/test_read_back.py", "tests/test_shown.py"
HEADING = re.compile(r"^(\S+):$", re.MULTILINE)
"""A file of `faults.yaml`."""


SURVIVED = "SURVIVED"
SLOW = "slow"
QUICK = f"not {SLOW}"
ENOUGH = 6.0
"""Of the tests that call a function, the quickest run first, up to this sum of their times [s]."""

CHUNKS = 24
"""In how many parts the files of the tests are, while it is noted what they call."""

MOST_FILES = 12
"""How many files of such tests run as a whole afterwards."""


class Told(NamedTuple):
    """A fault, and which tests catch it: a stage of `plant`, "all tests", or none."""

    file: str
    old: str
    new: str
    told: str


class Called(NamedTuple):
    """A test, how long it takes [s], and what it calls: files with the lines at which functions and macros begin."""

    test: str
    seconds: float
    places: frozenset[tuple[str, int]]


class Calls:
    """A plugin of pytest that notes what tests call."""

    def __init__(self) -> None:
        self.noted: dict[str, Called] = {}
        self.failed: set[str] = set()
        self.file = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Leave out a test that does not pass while it is watched."""
        if not report.passed:
            self.failed.add(report.nodeid)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Note what a test calls, with what earlier files have left to it worked out once more."""
        if self.file != (file := item.nodeid.partition("::")[0]):
            self.file = file
            forget_answers()
        seen: dict[CodeType, tuple[str, int] | None] = {}
        home = f"{os.getcwd()}/"

        def note(frame: FrameType, event: str, argument: object) -> None:
            code = frame.f_code
            if code not in seen:
                file, line = code.co_filename, code.co_firstlineno
                if template := frame.f_globals.get("__jinja_template__"):
                    line = template.get_corresponding_lineno(line)
                seen[code] = (file.removeprefix(home), line) if file.startswith(home) else None

        begun = time.process_time()
        sys.settrace(note)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            places = frozenset(place for place in seen.values() if place and not place[0].startswith("tests/"))
            self.noted[item.nodeid] = Called(item.nodeid, time.process_time() - begun, places)


def forget_answers() -> None:
    """Drop what `tests/conftest.py` keeps of one test for others."""
    import conftest

    for name in ("study", "solved"):
        getattr(conftest, name).cache_clear()
    for module, name in conftest.KNOWN:
        known = getattr(sys.modules.get(module), name, None)
        if isinstance(known, conftest.Known):
            known.answers.clear()


def prepare(folder: str) -> None:
    """Make a copy of the project the one that this process works in, and solve the scenarios of its tests."""
    copy = mkdtemp(dir=folder)
    ignored = shutil.ignore_patterns(".git", ".venv", "__pycache__")
    shutil.copytree(ROOT, copy, ignore=ignored, dirs_exist_ok=True)
    os.chdir(copy)
    os.environ |= {"PYTHONPATH": copy}
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # to compile all modules for each fault takes longer than its tests
    sys.path[:0] = [copy, f"{copy}/tests"]
    from test_read_back import EXAMPLE_RUNS, study_of_example
    from test_shown import OPENED, study_of

    for name in OPENED:
        study_of(name)
    for name in EXAMPLE_RUNS:
        study_of_example(name)


def run(tests: Sequence[str], anew: bool, plugins: Sequence[object] = (), marked: str = QUICK) -> int:
    """The exit code of pytest in a fork; anew, it imports the copy's modules once more."""
    if not (fork := os.fork()):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job in the background ignores
        code: int = pytest.ExitCode.INTERNAL_ERROR
        try:
            for name, module in list(sys.modules.items()) if anew else ():
                if (getattr(module, "__file__", None) or "").startswith(os.getcwd()):
                    del sys.modules[name]
            warnings = ("--assert=plain", "-W", "ignore::pytest.PytestAssertRewriteWarning")
            options = ("-q", "-p", "no:cacheprovider", "-m", marked)
            code = pytest.main([*options, *warnings, *tests], plugins=list(plugins))
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1])


def caught(tests: Sequence[str], anew: bool, marked: str = QUICK) -> bool:
    """Whether one of some tests, the quick ones by default, fails in the copy; a file may have none of them."""
    passing = pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED
    return bool(tests) and run(["-x", *tests], anew, marked=marked) not in passing


def note_calls(files: Sequence[str]) -> list[Called]:
    """What the quick tests of some files call."""
    with TemporaryDirectory() as folder:
        kept = Path(folder, "calls")

        class Kept(Calls):
            def pytest_sessionfinish(self) -> None:
                passed = [called for test, called in self.noted.items() if test not in self.failed]
                kept.write_bytes(pickle.dumps((passed, self.failed)))

        run(files, False, (Kept(),))
        noted, failed = pickle.loads(kept.read_bytes())
    for test in failed:
        print(f"does not pass without a fault, and is left out: {test}", flush=True)
    return list(noted)


@cache
def known_calls(kept: str) -> list[Called]:
    """What the tests call, as it was kept in a file."""
    return [Called(test, seconds, frozenset(places)) for test, seconds, places in pickle.loads(Path(kept).read_bytes())]


def callers(file: str, text: str, old: str, calls: Sequence[Called]) -> list[Called]:
    """The tests that call the function or the macro in which a text stands, the quickest first.

    What stands in no function is looked for by all tests that call something of its file.
    """
    first = text[: text.index(old)].count("\n") + 1
    last = first + old.count("\n")
    begins = {line for called in calls for name, line in called.places if name == file}
    around = {max((line for line in begins if line <= at), default=0) for at in (first, last)}
    if Path(file).suffix == ".py":
        around = {start for start in around if start and within(text, start, first)}
    chosen = [called for called in calls if any((file, line) in called.places for line in around)]
    chosen = chosen or [called for called in calls if any(name == file for name, _ in called.places)]
    return sorted(chosen, key=lambda called: called.seconds)


def within(text: str, start: int, line: int) -> bool:
    """Whether a line of code is one of the function that starts at a line, with its decorators."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.Lambda):
            begin = min([node.lineno, *(of.lineno for of in getattr(node, "decorator_list", ()))])
            if begin == start and begin <= line <= (node.end_lineno or begin):
                return True
    return False


def places_of(file: str, old: str) -> int:
    """How often the text that a fault replaces stands in its file."""
    path = ROOT / file
    return path.read_text(encoding="utf-8").count(old) if path.is_file() else 0


def rewrite(path: Path, text: str) -> None:
    """Write a file anew, and drop what it was compiled to: within a second, and of one length, both would be alike."""
    path.write_text(text, encoding="utf-8")
    for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
        compiled.unlink()


def tests_of_package(path: Path) -> list[str]:
    """The folder of tests that mirrors the package of a module; none for a template of the core."""
    if "vireport" not in path.parts:
        return []
    folders = (Path("tests", *parent.parts[1:]) for parent in path.parents if parent.parts[1:])
    return [str(folder) for folder in folders if folder.is_dir()][:1]


def plant(fault: tuple[str, str, str, bool, str]) -> Told:
    """What becomes of a fault in the copy of this process."""
    file, old, new, whole, kept = fault
    path, told = Path(file), SURVIVED
    text, anew = path.read_text(encoding="utf-8"), path.suffix in (".py", ".json")
    by = callers(file, text, old, known_calls(kept))
    sums = list(accumulate(called.seconds for called in by))
    first = [called.test for called, total in zip(by, sums, strict=True) if total <= ENOUGH]
    files = [name for name in dict.fromkeys(called.test.partition("::")[0] for called in by) if name not in READ_BACK]
    stages = {
        "callers": (first or [called.test for called in by[:1]], QUICK),
        "read back": (READ_BACK, QUICK),
        "files": (files[:MOST_FILES], QUICK),
        SLOW: ((*READ_BACK, *tests_of_package(path)), SLOW),
    }
    rewrite(path, text.replace(old, new))
    try:
        told = next((stage for stage, (tests, marked) in stages.items() if caught(tests, anew, marked)), told)
        if told == SURVIVED and whole and caught(["tests"], anew):
            told = "all tests"
    finally:
        rewrite(path, text)
    print(f"{told:9} {file}: {old[:70]} -> {new[:70]}".replace("\n", " "), flush=True)
    return Told(file, old, new, told)


PLACES = {
    "pages of other commands": r"templates/(words/)?(map|chart|compar|optimise|verify|changes)|"
    "vireport/(identify|verify|bench|map|comparison|optimise|report/changes)",
    "words of the report, its figures and additions": r"(vireport/findings/\w+/)?templates/words/",
    "tables and sentences of the report": r"(vireport/findings/\w+/)?templates/",
    "requirements, alerts and verdict": "vireport/study/judging|vireport/text",
    "numbers of the report": "vireport/report",
    "figures": "vireport/figures",
    "motions, design and proofs": "vireport",
}
"""What the counts are told of, by the beginnings of paths; the first that fits."""


def place_of(file: str) -> str:
    """The place that a fault is counted with."""
    return next(place for place, beginning in PLACES.items() if re.match(beginning, file))


def counted(faults: Iterable[Told]) -> list[dict[str, object]]:
    """How many were planted in each place, how many of them were caught, and how many of these by slow tests alone."""
    planted: Counter[str] = Counter()
    found: Counter[str] = Counter()
    slow: Counter[str] = Counter()
    for fault in faults:
        place = place_of(fault.file)
        planted[place] += 1
        found[place] += fault.told != SURVIVED
        slow[place] += fault.told == SLOW
    return [
        {"place": place, "planted": planted[place], "caught": found[place], "by_slow_tests": slow[place]}
        for place in PLACES
        if planted[place]
    ]


def main() -> int:
    """Plant every fault that is asked for, and count what becomes of them."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--only", default="", help="a pattern for the paths of the files in which faults are planted")
    asked.add_argument("--calls", type=Path, help="the file in which it is kept what each test calls")
    asked.add_argument("--whole", action="store_true", help="run all quick tests on what survives the others")
    asked.add_argument("--check", action="store_true", help="tell only which faults cannot be planted")
    asked.add_argument("--record", action="store_true", help="keep the counts for docs/accuracy.md")
    given = asked.parse_args()
    text = (ROOT / "tools" / "faults.yaml").read_text(encoding="utf-8")
    if twice := [file for file, count in Counter(HEADING.findall(text)).items() if count > 1]:
        print(f"headings that stand more than once, of which YAML keeps the last: {', '.join(twice)}")
        return 2
    table = yaml.safe_load(text)
    faults = [(file, *fault) for file, of in table.items() if re.search(given.only, file) for fault in of]
    for file, old, _ in (lost := [fault for fault in faults if places_of(*fault[:2]) != 1]):
        print(f"{file}: {old!r} stands there {places_of(file, old)} times, and not once")
    if lost or given.check:
        return 2 if lost else 0
    with TemporaryDirectory() as folder:
        fork = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(given.jobs, fork, prepare, (folder,)) as pool:
            kept = (given.calls or Path(folder, "calls")).absolute()
            if not kept.is_file():
                tests = sorted(str(test.relative_to(ROOT)) for test in (ROOT / "tests").rglob("test_*.py"))
                chunks = [tests[k::CHUNKS] for k in range(CHUNKS)]
                kept.write_bytes(pickle.dumps([tuple(of) for noted in pool.map(note_calls, chunks) for of in noted]))
            outcomes = list(pool.map(plant, [(*fault, given.whole, str(kept)) for fault in faults]))
    counts = Counter(fault.told for fault in outcomes)
    print(f"{len(outcomes)} faults planted, {len(outcomes) - counts[SURVIVED]} caught: {dict(counts)}")
    if given.record:
        listed = sum(len(of) for of in table.values())
        record = {"date": date.today().isoformat(), "listed": listed, "places": counted(outcomes)}
        RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return int(SURVIVED in counts)


if __name__ == "__main__":
    sys.exit(main())
