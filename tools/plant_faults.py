"""Plant the faults of `faults.yaml` one at a time into a copy of the project, and tell which the quick tests catch.

    python tools/plant_faults.py [--jobs 2] [--only PART] [--whole] [--check] [--record]

Of a fault in a template the tests that read pages and terminals back run first, of one in code the quick tests of its
package; of what survives them, the others; with --whole, all quick tests of what is left. With --check no test runs: it
tells only which faults have no place, or several, in their file. Nothing in the working tree is changed, but for
`benchmarks/results/faults.json` with --record: the counts for docs/accuracy.md.

A template is read anew by each report, so that a fault in one needs no new process: the tests run in a fork of one that
has solved their scenarios. That takes a second instead of a minute.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from datetime import date
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import NamedTuple

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / "benchmarks" / "results" / "faults.json"
READ_BACK = ("tests/test_shown.py",)
TESTS = {
    "templates/sections/paper": ("tests/study/checks/test_paper.py", "tests/report"),
    "templates/sections/motions": ("tests/motions/atlas/test_results.py", "tests/text"),
    "templates/sections": ("tests/report", "tests/text"),
    "templates/words/figures": ("tests/text", "tests/figures"),
    "vireport/identify/templates/words/identify": ("tests/identify/test_identify_opening.py", "tests/text"),
    "templates/words": ("tests/text", "tests/study/judging", "tests/report"),
    "vireport/identify": ("tests/identify/test_identify_opening.py",),
    "vireport/verify/outputs": ("tests/verify/test_outputs.py",),
    "vireport/findings/outcomes": ("tests/findings/outcomes/test_withstood.py",),
    "vireport/physics/cubics": ("tests/simulation/test_recorded_force.py",),
    "vireport/physics/groups": ("tests/motions/test_two_restitutions.py", "tests/physics/test_friction_group.py"),
    "vireport/motions/plane": ("tests/motions/test_motion_plane.py", "tests/motions/test_friction.py"),
    "vireport/changes": ("tests/report/changes", "tests/comparison"),
    "vireport/optimise": ("tests/optimise/test_best_design.py",),
    "vireport/text": ("tests/text", "tests/study/judging"),
}
"""Quick tests beside those that read back, by the beginning of a file's path; else those of its package."""

HEADING = re.compile(r"^(\S+):$", re.MULTILINE)
"""A file of `faults.yaml`."""


def tests_of(file: str) -> tuple[str, ...]:
    """The quick tests beside those that read back."""
    own = (f"tests/{Path(file).parts[1]}",)
    return next((tests for beginning, tests in TESTS.items() if file.startswith(beginning)), own)


SURVIVED = "SURVIVED"


class Told(NamedTuple):
    """A fault, and who catches it: "read back", "other tests", or nobody."""

    file: str
    old: str
    new: str
    told: str


def prepare(folder: str) -> None:
    """Make a copy of the project the one that this process works in, and solve the scenarios of its tests."""
    copy = mkdtemp(dir=folder)
    ignored = shutil.ignore_patterns(".git", ".venv", "__pycache__")
    shutil.copytree(ROOT, copy, ignore=ignored, dirs_exist_ok=True)
    os.chdir(copy)
    os.environ |= {"PYTHONPATH": copy}
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # to compile all modules for each fault takes longer than its tests
    sys.path[:0] = [copy, f"{copy}/tests"]
    from test_shown import OPENED, study_of

    for name in OPENED:
        study_of(name)


QUICK = ("-x", "-q", "-p", "no:cacheprovider", "-m", "not slow")


def caught(tests: tuple[str, ...]) -> bool:
    """Whether one of some quick tests fails in the copy."""
    return subprocess.run([sys.executable, "-m", "pytest", *QUICK, *tests], capture_output=True).returncode != 0


def caught_in_a_fork(tests: tuple[str, ...]) -> bool:
    """The same where a template was changed, with the scenarios that are solved already."""
    if not (fork := os.fork()):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        code: int = pytest.ExitCode.INTERNAL_ERROR
        try:
            code = pytest.main([*QUICK, "--assert=plain", "-W", "ignore::pytest.PytestAssertRewriteWarning", *tests])
        finally:
            os._exit(code)
    return os.waitpid(fork, 0)[1] != 0


def places_of(file: str, old: str) -> int:
    """How often the text that a fault replaces stands in its file."""
    path = ROOT / file
    return path.read_text(encoding="utf-8").count(old) if path.is_file() else 0


def rewrite(path: Path, text: str) -> None:
    """Write a file anew, and drop what it was compiled to: within a second, and of one length, both would be alike."""
    path.write_text(text, encoding="utf-8")
    for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
        compiled.unlink()


def plant(fault: tuple[str, str, str, bool]) -> Told:
    """What becomes of a fault in the copy of this process."""
    file, old, new, whole = fault
    path, told = Path(file), SURVIVED
    text = path.read_text(encoding="utf-8")
    rewrite(path, text.replace(old, new))
    code = path.suffix == ".py"
    quick = caught if code else caught_in_a_fork
    reading, others = ("read back", READ_BACK), ("other tests", tests_of(file))
    try:
        told = next((kind for kind, tests in ((others, reading) if code else (reading, others)) if quick(tests)), told)
        if told == SURVIVED and whole and caught(("-n", "2", "tests")):
            told = "other tests"
    finally:
        rewrite(path, text)
    print(f"{told:12} {file}: {old[:70]} -> {new[:70]}".replace("\n", " "), flush=True)
    return Told(file, old, new, told)


PLACES = {
    "tables and sentences of the report": ("templates/sections",),
    "words of verdict, proofs and captions": ("templates/words",),
    "requirements, alerts and verdict": ("vireport/gate", "vireport/text"),
    "numbers of the report": ("vireport/report",),
    "the best design": ("vireport/optimise",),
    "figures": ("vireport/figures",),
    "comparisons and charts": ("vireport/comparison", "vireport/chart"),
    "motions, design and proofs": ("vireport",),
}
"""What the counts are told of, by the beginnings of paths; the first that fits."""


def place_of(file: str) -> str:
    """The place that a fault is counted with."""
    return next(place for place, beginnings in PLACES.items() if file.startswith(beginnings))


def counted(faults: Iterable[Told]) -> list[dict[str, object]]:
    """How many were planted in each place, and how many of them were caught."""
    planted: Counter[str] = Counter()
    found: Counter[str] = Counter()
    for fault in faults:
        place = place_of(fault.file)
        planted[place] += 1
        found[place] += fault.told != SURVIVED
    return [{"place": place, "planted": planted[place], "caught": found[place]} for place in PLACES if planted[place]]


def main() -> int:
    """Plant every fault that is asked for, and count what becomes of them."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--only", default="", help="a part of the path of the files in which faults are planted")
    asked.add_argument("--whole", action="store_true", help="run all quick tests on what survives the others")
    asked.add_argument("--check", action="store_true", help="tell only which faults cannot be planted")
    asked.add_argument("--record", action="store_true", help="keep the counts for docs/accuracy.md")
    given = asked.parse_args()
    text = (ROOT / "tools" / "faults.yaml").read_text(encoding="utf-8")
    if twice := [file for file, count in Counter(HEADING.findall(text)).items() if count > 1]:
        print(f"headings that stand more than once, of which YAML keeps the last: {', '.join(twice)}")
        return 2
    table = yaml.safe_load(text)
    faults = [(file, *fault) for file, of in table.items() if given.only in file for fault in of]
    for file, old, _ in (lost := [fault for fault in faults if places_of(*fault[:2]) != 1]):
        print(f"{file}: {old!r} stands there {places_of(file, old)} times, and not once")
    if lost or given.check:
        return 2 if lost else 0
    with TemporaryDirectory() as folder:
        fork = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(given.jobs, fork, prepare, (folder,)) as pool:
            if pool.submit(caught_in_a_fork, READ_BACK).result():
                print("the tests that read back fail without a fault")
                return 2
            outcomes = list(pool.map(plant, [(*fault, given.whole) for fault in faults]))
    counts = Counter(fault.told for fault in outcomes)
    print(f"{len(outcomes)} faults planted, {len(outcomes) - counts[SURVIVED]} caught: {dict(counts)}")
    if given.record:
        kept = {"date": date.today().isoformat(), "places": counted(outcomes)}
        RECORD.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    return int(SURVIVED in counts)


if __name__ == "__main__":
    sys.exit(main())
