"""The notebooks of the examples: small, without outputs, and they run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((ROOT / "examples").rglob("*.ipynb"))
LARGEST = 10_000
"""Bytes of a notebook: without outputs a few thousand."""

SHOWN = {
    "decide": ("DesignPoint s = 0.75 m: 2 motions, stable node", "U_ave = 926 V", "0.8 m: 978 V", "<Verdict Stable"),
    "parameter-study": ("Best: inclination 15°", "stable node    0.630522  0.75", "margin_percent", "43140.5"),
}
"""What the cells of a notebook show, in this order."""


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_small_and_has_no_outputs(file: Path) -> None:
    assert file.stat().st_size < LARGEST
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None
    for page in ("docs/examples.md", "docs/how-to.md", ".ci/run"):
        assert f"examples/{file.name}" in (ROOT / page).read_text(encoding="utf-8")


def output(of: dict[str, Any]) -> str:
    return str(of["text"] if of["output_type"] == "stream" else of["data"]["text/plain"])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::RuntimeWarning")  # of the packages that run it
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_and_shows_what_it_says(file: Path) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(file, as_version=4)
    nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(file.parent)}}, timeout=300).execute()
    text = "\n".join(output(each) for cell in notebook.cells for each in cell.get("outputs", ()))
    place = 0
    for shown in SHOWN[file.stem]:
        place = text.find(shown, place)
        assert place >= 0, (shown, text)
