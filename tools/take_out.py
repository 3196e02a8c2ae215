"""Takes an addition out in a copy of the project, and shows that the rest stands without it.

    python tools/take_out.py NAME [PYTEST ARGUMENT ...]

Its packages go, with their tests, templates and pages of the documentation, its row of `base/additions.py`, its layer
in the import contract and its names in `vireport/__init__.py`. So do those of the additions that need it. Then the
import contract is checked and the quick tests are run, but for those of several rooms at once that need the addition
(`OF_ADDITIONS` of `tests/conftest.py`). The example gives the same results as with the addition, but for the addition's
own, and a scenario with each of its keys ends with exit code 2 and the key's line.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from msgspec import convert

from vireport.base.additions import ADDITIONS, complete
from vireport.base.records import plain
from vireport.scenario.blocks import Scenario, keys_of_additions
from vireport.study.judging.findings import findings
from vireport.study.result_records import DisturbancesData

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = "examples/inclined.yaml"


def copy_of_project(folder: Path) -> None:
    """Copy the files that are under version control, as they are now."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def going_with(name: str) -> list[str]:
    """An addition, and those that need it."""
    rest = complete({other: row for other, row in ADDITIONS.items() if other != name})
    return [name, *(other for other in ADDITIONS if other not in rest and other != name)]


def remove(folder: Path, name: str) -> None:
    """Take an addition out of a copy of the project."""
    packages = ADDITIONS[name].packages
    folders = [folder.name for package in packages for folder in (ROOT / "vireport" / package).glob("[a-z]*/")]
    for place in (package.replace(".", "/") for package in packages):
        shutil.rmtree(folder / "vireport" / place)
        shutil.rmtree(folder / "tests" / place, ignore_errors=True)
    for word in {name, *packages, *folders}:
        for file in (f"docs/{word}.md", f"templates/{word}.typ.j2", f"templates/words/{word}.j2"):
            (folder / file).unlink(missing_ok=True)
        shutil.rmtree(folder / "templates" / word, ignore_errors=True)
    for example in (folder / "examples").glob("*.yaml"):
        text = example.read_text(encoding="utf-8")
        if any(re.search(rf"^ *{key.rpartition('.')[2]}:", text, re.MULTILINE) for key in keys_of(name)):
            example.unlink()
    either = "|".join(map(re.escape, packages))
    without_lines(folder / "vireport/base/additions.py", rf'^    "{name}": ')
    without_lines(folder / "vireport/__init__.py", rf"^    from vireport\.({either})\.|^    \"vireport\.({either})\.")
    names = [
        word
        for place, words in public_names().items()
        if place.startswith(tuple(f"vireport.{package}." for package in packages))
        for word in words
    ]
    if names:
        without_lines(folder / "vireport/__init__.py", rf'^    "({"|".join(names)})",$')
    contract, layer = folder / "pyproject.toml", "|".join(package.rpartition(".")[2] for package in packages)
    layers = re.sub(rf" \| ({layer})\b|\b({layer}) \| ", "", contract.read_text(encoding="utf-8"))
    contract.write_text(re.sub(rf'^  "({layer})",\n', "", layers, flags=re.MULTILINE), encoding="utf-8")
    contributing = folder / "CONTRIBUTING.md"
    without_lines(contributing, rf"^\| `({either})` \|")


def keys_of(name: str) -> list[str]:
    """The paths of the keys of a scenario that are known where an addition is."""
    return [*added_by(name), *(path for path, addition in keys_of_additions(Scenario) if addition == name)]


def added_by(name: str) -> list[str]:
    """The paths of the keys of a scenario that an addition brings."""
    row = ADDITIONS[name]
    return list(import_module(f"vireport.{row.packages[0]}.keys").KEYS) if "keys" in row.declares else []


def same_results(names: list[str], without: Any) -> bool:
    """Whether the example gives the same with and without additions, but for their keys and steps."""
    data = results(ROOT)
    for name in names:
        for path in keys_of(name):
            block, _, key = path.rpartition(".")
            ((data["scenario"].get(block) if block else data["scenario"]) or {}).pop(key, None)
        if (finding := findings().get(name)) is None:
            continue
        for key in finding.results(None, None):
            del data[key]
        steps = {row.task for row in finding.steps()}
        data["left_out"] = [row for row in data["left_out"] if row["step"] not in steps]
        if (block := without.get(finding.extends)) is not None:
            without[finding.extends] = plain(finding.results_within(convert(block, DisturbancesData), None))
    return bool(data == without)


def without_lines(file: Path, pattern: str) -> None:
    """Delete the lines of a file that a pattern is in."""
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(line for line in lines if not re.search(pattern, line)), encoding="utf-8")


def public_names() -> dict[str, list[str]]:
    """The names that `import vireport` gives, by the module that defines them."""
    text = (ROOT / "vireport" / "__init__.py").read_text(encoding="utf-8")
    return {
        module: re.findall(r'"(\w+)"', names)
        for module, names in re.findall(r'^    "([\w.]+)": \((.*)\),$', text, re.M)
    }


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python on the package of a folder."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True)


def results(folder: Path) -> Any:
    """The results of the example, without what says where they were made."""
    printed = run(folder, "-m", "vireport", "run", EXAMPLE, "--json")
    data = json.loads(printed.stdout)
    del data["provenance"]
    return data


def with_key(lines: list[str], path: str) -> tuple[list[str], int]:
    """The lines of a scenario with one more key, which is of no block or of one at the top, and the key's line."""
    block, _, key = path.rpartition(".")
    if not block:
        return [*lines, f"{key}: 1"], len(lines) + 1
    if f"{block}:" not in lines:
        return [*lines, f"{block}:", f"  {key}: 1"], len(lines) + 2
    begins = lines.index(f"{block}:") + 1
    return [*lines[:begins], f"  {key}: 1", *lines[begins:]], begins + 1


def mistakes(folder: Path, names: list[str]) -> list[str]:
    """What is wrong in a copy without some additions; an empty list where all is as it should be."""
    wrong = [] if same_results(names, results(folder)) else [f"the results of {EXAMPLE} differ"]
    wrong += [mistake for name in names for mistake in remains(folder, name)]
    text, keys = (folder / EXAMPLE).read_text(encoding="utf-8"), {key for name in names for key in keys_of(name)}
    # Of a key in a block that is unknown as well, the block is refused.
    for path in sorted(key for key in keys if key.rpartition(".")[0] not in keys):
        given, line = with_key(text.splitlines(), path)
        (folder / "with.yaml").write_text("\n".join(given), encoding="utf-8")
        refused = run(folder, "-m", "vireport", "run", "with.yaml", "--json")
        if refused.returncode != 2 or f"with.yaml:{line}: {path}: unknown key" not in refused.stderr:
            wrong.append(f"the key {path} is not refused: {refused.stderr.strip()}")
    return wrong


def remains(folder: Path, name: str) -> list[str]:
    """What there still is of the code of an addition in a copy that is to be without it."""
    wrong, row = [], ADDITIONS[name]
    if run(folder, "-c", f"import vireport.{row.packages[0]}").returncode == 0:
        wrong.append(f"the package {row.packages[0]} can still be imported")
    for word in (name, *row.old_names) if "command" in row.declares else ():
        refused = run(folder, "-m", "vireport", word, EXAMPLE)
        if refused.returncode != 2 or f"'{word}'" not in refused.stderr:
            wrong.append(f"vireport {word} is not refused as no command: {refused.stderr.strip()}")
    return wrong


def main() -> int:
    """Take out the addition that is named; returns 0 where the rest stands."""
    if sys.argv[1:2] == [] or sys.argv[1] not in ADDITIONS:
        print(f"python tools/take_out.py NAME (allowed: {', '.join(ADDITIONS)})")
        return 2
    name, *arguments = sys.argv[1:]
    names = going_with(name)
    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        copy_of_project(folder)
        for addition in names:
            remove(folder, addition)
        run(folder, "tools/write_keys.py")
        wrong = mistakes(folder, names)
        contract = run(folder, "-c", "from importlinter.cli import lint_imports; raise SystemExit(lint_imports())")
        if contract.returncode:
            wrong.append(f"the import contract is broken:\n{contract.stdout}")
        tests = run(folder, "-m", "pytest", "-q", "-m", "not slow", *(arguments or ["-n", "auto"]))
        if tests.returncode:
            wrong.append(tests.stdout[-6000:])
        print("\n".join(wrong) or f"without {', '.join(names)}: {tests.stdout.strip().splitlines()[-1]}")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
