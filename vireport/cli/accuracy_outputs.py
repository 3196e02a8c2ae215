"""What `vireport verify` prints and writes: the text, the figures and the data of what was measured."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec.structs import replace

from vireport.base.encoding import json_text
from vireport.checks.accuracy_tables import measurements, ranking
from vireport.checks.workprecision import accuracy_data
from vireport.membranes.compliance import compliance_data
from vireport.membranes.compliance_tables import comparison_with_rigid, solvers_on_stiff_membranes, verdict
from vireport.scenario.blocks import AccuracyBlock
from vireport.scenario.loading import Loaded
from vireport.study.plan import Task
from vireport.study.provenance import provenance_of
from vireport.study.study import Study, analyse
from vireport.text.formatting import capital
from vireport.text.tables import Table, plain_text
from vireport.wording.templates import Words

if TYPE_CHECKING:
    from vireport.base.progress import Progress


NAMES = ("accuracy.json", "figure-accuracy.png", "figure-stiffness.png")
"""Files that may be written."""


WORDS = Words("accuracy")

FORMATS = Task.PNG, Task.JSON
"""What a study of accuracy has."""


def asked(loaded: Loaded) -> Loaded:
    """The scenario with its accuracy block, or with the default one where it has none.

    Simulation and requirements are left out: they are not what is asked for here.
    """
    block = loaded.scenario.accuracy or AccuracyBlock()
    changes = {"accuracy": block, "simulation": None, "requirements": None}
    return replace(loaded, scenario=loaded.scenario.model_copy(update=changes))


def measured(loaded: Loaded, progress: Progress | None = None) -> Study:
    """Study a scenario that was `asked` for its accuracy."""
    return analyse(loaded, FORMATS, progress)


def text(study: Study, every: bool = False) -> str:
    """What was measured, for the terminal; with `every`, each run in a row."""
    return plain_text(_parts(study, every)).replace("*", "") + "\n"


def _parts(study: Study, every: bool) -> Iterator[str | Table]:
    if study.work is None:
        return
    if study.work.nothing:
        yield capital(study.work.nothing)
    if study.work.busy:
        yield WORDS("busy", study.work.unsteadiness)
    yield from measurements(study.work, every)
    yield from ranking(study.work)
    if study.compliance is None:
        why = next(step.why for step in study.plan.steps if step.task is Task.COMPLIANT)
        yield f"Compliant membranes: left out ({why})"
        return
    yield f"Compliant membranes: {verdict(study.compliance)}"
    yield from comparison_with_rigid(study.compliance)
    yield from solvers_on_stiff_membranes(study.compliance)


def data(study: Study, command: str) -> bytes:
    """What was measured by a command, as JSON."""
    content = {
        "scenario_sha256": study.loaded.sha256,
        "accuracy": None if study.work is None else accuracy_data(study.work),
        "compliant": None if study.compliance is None else compliance_data(study.compliance),
        "provenance": provenance_of(study.loaded, command).to_dict(),
    }
    return (json_text(content, indent=1) + "\n").encode()


def files(study: Study, command: str, width_mm: float | None = None) -> dict[str, bytes]:
    """The figures, as wide as a column of a paper where a width is given, and accuracy.json, by their names."""
    from vireport.figures.pictures import measured_pictures
    from vireport.figures.style import Sheet, drawn_for

    with drawn_for(Sheet.of(width_mm)):
        drawn = {f"{picture.name}.png": picture.png for picture in measured_pictures(study)}
    return {"accuracy.json": data(study, command), **drawn}
