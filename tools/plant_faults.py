"""Plant the faults of `faults.yaml` one at a time into a copy of the project, and tell which the quick tests catch.

    python tools/plant_faults.py [--jobs 2] [--only PART] [--whole] [--check]

First the tests that read pages and terminals back run; of a fault that survives them, the other quick tests of its
package; with --whole, all quick tests of what is left. With --check no test runs: it tells only which faults have no
place, or several, in their file. Nothing in the working tree is changed.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory

import yaml

ROOT = Path(__file__).resolve().parent.parent
READ_BACK = ("tests/test_shown.py",)
TESTS = {
    "templates/sections/paper": ("tests/checks/test_paper.py", "tests/report"),
    "templates/sections/motions": ("tests/atlas/test_results.py", "tests/wording"),
    "templates/sections": ("tests/report", "tests/wording"),
    "templates/words/figures": ("tests/wording", "tests/figures"),
    "templates/words": ("tests/wording", "tests/gate", "tests/report"),
    "vireport/shocks": ("tests/shocks/test_withstood.py",),
    "vireport/physics/groups": ("tests/motions/test_two_restitutions.py", "tests/physics/test_friction_group.py"),
    "vireport/optimise": ("tests/optimise/test_best_design.py",),
    "vireport/text": ("tests/text", "tests/gate"),
}
"""Quick tests beside those that read back, by the beginning of a file's path; else those of its package."""


def tests_of(file: str) -> tuple[str, ...]:
    """The quick tests beside those that read back."""
    own = (f"tests/{Path(file).parts[1]}",)
    return next((tests for beginning, tests in TESTS.items() if file.startswith(beginning)), own)


def caught(copy: Path, tests: tuple[str, ...]) -> bool:
    """Whether one of some quick tests fails in a copy of the project."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", *tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(command, cwd=copy, env=environment, capture_output=True).returncode != 0


def places_of(file: str, old: str) -> int:
    """How often the text that a fault replaces stands in its file."""
    path = ROOT / file
    return path.read_text(encoding="utf-8").count(old) if path.is_file() else 0


def outcome(copy: Path, file: str, old: str, new: str, whole: bool) -> str:
    """What becomes of a fault: who catches it, or nobody."""
    path = copy / file
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(old, new), encoding="utf-8")
    try:
        if caught(copy, READ_BACK):
            return "read back"
        if caught(copy, tests_of(file)):
            return "other tests"
        return "other tests" if whole and caught(copy, ("-n", "2", "tests")) else "SURVIVED"
    finally:
        path.write_text(text, encoding="utf-8")


def main() -> int:
    """Plant every fault that is asked for, and count what becomes of them."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--only", default="", help="a part of the path of the files in which faults are planted")
    asked.add_argument("--whole", action="store_true", help="run all quick tests on what survives the others")
    asked.add_argument("--check", action="store_true", help="tell only which faults cannot be planted")
    given = asked.parse_args()
    table = yaml.safe_load((ROOT / "tools" / "faults.yaml").read_text(encoding="utf-8"))
    faults = [(file, *fault) for file, of in table.items() if given.only in file for fault in of]
    for file, old, _ in (lost := [fault for fault in faults if places_of(*fault[:2]) != 1]):
        print(f"{file}: {old!r} stands there {places_of(file, old)} times, and not once")
    if lost or given.check:
        return 2 if lost else 0
    with TemporaryDirectory() as folder:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(given.jobs):
            copy = Path(folder) / str(number)
            shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".git", ".venv", "__pycache__"))
            copies.put(copy)
            if caught(copy, READ_BACK):
                print("the tests that read back fail without a fault")
                return 2

        def plant(fault: tuple[str, str, str]) -> str:
            copy = copies.get()
            try:
                told = outcome(copy, *fault, given.whole)
            finally:
                copies.put(copy)
            file, old, new = (text.replace("\n", " ") for text in fault)
            print(f"{told:12} {file}: {old[:70]} -> {new[:70]}", flush=True)
            return told

        with ThreadPoolExecutor(given.jobs) as pool:
            outcomes = list(pool.map(plant, faults))
    counts = {told: outcomes.count(told) for told in dict.fromkeys(outcomes)}
    print(f"{len(outcomes)} faults planted, {len(outcomes) - counts.get('SURVIVED', 0)} caught: {counts}")
    return int("SURVIVED" in counts)


if __name__ == "__main__":
    sys.exit(main())
