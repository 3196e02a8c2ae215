"""Follows docs/tutorial.md word by word: writes its files, runs its commands, and compares what they print.

    python tools/follow_tutorial.py [FOLDER]

FOLDER has the `vireport` that is run; without it, it is the package beside this file. A line `...` on the page stands
for any lines, and `...` within one for any text.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(yaml|console)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"# (\S+?)(, continued)?\n")


def followed(folder: Path, programs: Path) -> list[str]:
    """Follow the page in an empty folder; returns where what is printed is not what the page shows."""
    environment = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "100"}
    differences = []
    for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if kind == "yaml":
            write(folder, text)
            continue
        first, _, shown = text.partition("\n")
        run = subprocess.run(
            ["sh", "-c", first.removeprefix("$ ")],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
        )
        if not re.fullmatch(pattern_of(shown), run.stdout):
            differences.append(f"{first}\nshown:\n{shown}\nprinted:\n{run.stdout}")
    return differences


def write(folder: Path, text: str) -> None:
    """Write a file of the page, or go on with it."""
    name = NAMED.match(text)
    assert name is not None, f"no name of a file: {text}"
    with open(folder / name[1], "a" if name[2] else "w", encoding="utf-8") as file:
        file.write(text)


def write_files(folder: Path) -> None:
    """Write the files of the page as they are in the end."""
    for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if kind == "yaml":
            write(folder, text)


def pattern_of(shown: str) -> str:
    """A regular expression of what a page shows."""
    lines = (re.escape(line).replace(r"\.\.\.", ".*") + r"\n" for line in shown.splitlines())
    return "".join(r"(?:.*\n)*" if line == r".*\n" else line for line in lines)


def main() -> int:
    """Follow the page; returns 1 where it is not true."""
    with TemporaryDirectory() as temporary:
        folder, programs = Path(temporary, "work"), Path(temporary, "bin")
        folder.mkdir()
        programs.mkdir()
        if len(sys.argv) > 1:
            programs = Path(sys.argv[1]).resolve()
        else:
            program = programs / "vireport"
            program.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m vireport "$@"\n')
            program.chmod(0o755)
        differences = followed(folder, programs)
    print("\n".join(differences) or f"{PAGE.name}: every command prints what the page shows")
    return bool(differences)


if __name__ == "__main__":
    sys.exit(main())
