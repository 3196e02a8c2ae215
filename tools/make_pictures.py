"""Draws the pictures of README.md and docs/ into `examples/pictures`.

    python tools/make_pictures.py [--check] [NAME ...]

With --check, pictures that are out of date are named, and nothing is written. Needs vireport with its extras for
simulation and maps, and Chromium for the bench. Error against run time is drawn by benchmarks/accuracy.py, from the
measurement that docs/accuracy.md shows.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from shutil import rmtree
from subprocess import run
from tempfile import TemporaryDirectory, mkdtemp
from time import sleep

import typst
from follow_tutorial import write_files
from PIL import Image, ImageChops, ImageStat

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PICTURES = EXAMPLES / "pictures"

TUTORIAL = "device.yaml"
"""The device of the tutorial, as its page has it."""

COMMANDS = {
    "horizontal": ("run", "horizontal.yaml"),
    "inclined-forcing": ("run", "inclined-forcing.yaml"),
    "simulated": ("run", "simulated.yaml"),
    "hysteresis": ("run", "hysteresis.yaml"),
    "table": ("run", "bouncing-ball.yaml", "--set", "simulation.diagram=true", "--set", "simulation.samples=401"),
    "design-point": ("run", "design-point.yaml"),
    "paper": ("paper",),
    "compare": ("compare", "horizontal.yaml", "inclined.yaml", "inclined-forcing.yaml"),
    "chart": ("map", "inclined.yaml", "--over", "restitution=0.2..0.8,length_m=0.3..1"),
    "map": ("map", "maps/map.yaml"),
    "shortest": ("optimise", TUTORIAL, "--set", "requirements.margin_with_effects_percent=5"),
}

SHOWN = {
    "paper-figure-2": "paper/figure-2",
    "horizontal-figure-2": "horizontal/figure-2",
    "inclined-forcing-figure-7": "inclined-forcing/figure-7",
    "simulated-figure-2": "simulated/figure-2",
    "simulated-figure-3": "simulated/figure-3",
    "hysteresis": "hysteresis/figure-hysteresis",
    "bouncing-ball-diagram": "table/figure-diagram",
    "compare-figure-2": "compare/figure-2",
    "compare-figure-variants": "compare/figure-variants",
    "inclined-chart": "chart/figure-chart",
    "map-stability": "map/map-stability",
    "tutorial-front": "shortest/front",
}
"""Of each picture, the file that it is, without suffixes."""

REPORTS = {"design-point-report": "design-point/report", "tutorial-report": "shortest/report"}
"""The pictures of reports' first pages, and the reports."""

BENCH = "bench"
"""The picture of the page of `vireport explore`."""

BENCH_OPTIONS = "--set", "device.length_m=0.62", "--set", "requirements.margin_any_percent=5"
SETTLED = """!document.querySelector(".waiting") && !document.querySelector(".now").textContent
  && document.querySelector(".sentence").textContent !== ''"""

FIRST_PAGE = b'#set page(width: auto, height: auto, margin: 0pt)\n#image("report.pdf")'


SHRUNK = (200, 150)
"""Pixels in which two pictures are compared, so that the rendering of letters does not count."""

MOST_APART = 0.2
"""Mean difference of pixels, of 255, up to which pictures are the same: libraries draw lines a little differently."""


def main() -> int:
    """Draw the pictures of the documentation, or check those that there are; exit code 1 if one is out of date."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", choices=[[], *SHOWN, *REPORTS, BENCH], metavar="NAME", help="only these")
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    given = parser.parse_args()
    code = 0
    for name, png in drawn(given.names or [*SHOWN, *REPORTS, BENCH]):
        file = PICTURES / f"{name}.png"
        if not given.check:
            file.write_bytes(png)
        elif why := difference(png, file.read_bytes()):
            print(f"{file.name} is out of date ({why}): run python tools/make_pictures.py")
            code = 1
    return code


def drawn(names: Sequence[str]) -> Iterator[tuple[str, bytes]]:
    """Each picture with its PNG, from the examples run once each."""
    if BENCH in names:
        yield BENCH, bench()
    files = {name: Path((SHOWN | REPORTS)[name]) for name in names if name != BENCH}
    with TemporaryDirectory() as folder:
        for example in dict.fromkeys(file.parent.name for file in files.values()):
            command, *words = COMMANDS[example]
            places = {word: EXAMPLES / word for word in words if word.endswith(".yaml")}
            if TUTORIAL in places:
                write_files(Path(folder))
                places[TUTORIAL] = Path(folder, TUTORIAL)
            arguments = [str(places.get(word, word)) for word in words]
            run([sys.executable, "-m", "vireport", command, *arguments, "-o", f"{folder}/{example}"], check=True)
        for name, file in files.items():
            if name in REPORTS:
                compiler = typst.Compiler(root=f"{folder}/{file.parent}")
                yield name, compiler.compile(FIRST_PAGE, format="png", ppi=70.0)
            else:
                yield name, Path(folder, f"{file}.png").read_bytes()


def bench() -> bytes:
    """The bench with a design that falls short, as a browser shows it."""
    root = EXAMPLES.parent
    sys.path += [str(root / "tests"), str(root / "tests" / "bench")]
    from browser import Browser
    from serving import serving

    folder = mkdtemp()  # Chromium ends after us, and writes to its profile until then
    with serving(EXAMPLES / "inclined.yaml", Path(folder), *BENCH_OPTIONS) as served:
        browser = Browser(Path(folder) / "profile")
        browser.look(1440)
        browser.visit(served.address)
        while not browser.run(SETTLED):
            sleep(0.1)
        png = browser.look(1440)
        browser.end()
    rmtree(folder, ignore_errors=True)
    return png


def difference(new: bytes, old: bytes) -> str:
    """How two pictures differ, or "" where they are the same."""
    one, other = (Image.open(BytesIO(png)).convert("RGB") for png in (new, old))
    if one.size != other.size:
        return f"{other.size} pixels, now {one.size}"
    apart = ImageStat.Stat(ImageChops.difference(one.resize(SHRUNK), other.resize(SHRUNK)))
    mean = sum(apart.mean) / len(apart.mean)
    return f"pixels differ by {mean:.2g} on average" if mean > MOST_APART else ""


if __name__ == "__main__":
    raise SystemExit(main())
