"""Draws the pictures of README.md and docs/ into `examples/pictures`.

    python tools/make_pictures.py

Needs vireport with its extras for simulation and maps. Error against run time is drawn by benchmarks/accuracy.py, from
the measurement that docs/accuracy.md shows.
"""

from __future__ import annotations

import sys
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory

import typst

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PICTURES = EXAMPLES / "pictures"

COMMANDS = {
    "horizontal": ("run", "horizontal.yaml"),
    "inclined-forcing": ("run", "inclined-forcing.yaml"),
    "simulated": ("run", "simulated.yaml"),
    "hysteresis": ("run", "hysteresis.yaml"),
    "design-point": ("run", "design-point.yaml"),
    "compare": ("compare", "horizontal.yaml", "inclined.yaml", "inclined-forcing.yaml"),
    "chart": ("chart", "inclined.yaml", "--over", "restitution=0.2..0.8,length_m=0.3..1"),
    "map": ("sweep", "maps/map.yaml"),
}

SHOWN = {
    "horizontal-figure-2": "horizontal/figure-2",
    "inclined-forcing-figure-7": "inclined-forcing/figure-7",
    "simulated-figure-2": "simulated/figure-2",
    "simulated-figure-3": "simulated/figure-3",
    "hysteresis": "hysteresis/figure-hysteresis",
    "compare-figure-2": "compare/figure-2",
    "compare-figure-variants": "compare/figure-variants",
    "inclined-chart": "chart/figure-chart",
    "map-stability": "map/map-stability",
}
"""Of each picture, the file that it is, without suffixes."""

FIRST_PAGE = b'#set page(width: auto, height: auto, margin: 0pt)\n#image("report.pdf")'


def main() -> None:
    """Run the examples and copy what the documentation shows."""
    with TemporaryDirectory() as folder:
        for name, (command, *words) in COMMANDS.items():
            arguments = [str(EXAMPLES / word) if word.endswith(".yaml") else word for word in words]
            out = str(Path(folder) / name)
            run([sys.executable, "-m", "vireport", command, *arguments, "-o", out], check=True)
        for picture, file in SHOWN.items():
            (PICTURES / f"{picture}.png").write_bytes((Path(folder) / f"{file}.png").read_bytes())
        page = typst.Compiler(root=str(Path(folder) / "design-point")).compile(FIRST_PAGE, format="png", ppi=70.0)
        (PICTURES / "design-point-report.png").write_bytes(page)


if __name__ == "__main__":
    main()
