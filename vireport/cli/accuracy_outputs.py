"""What `vireport accuracy` prints and writes: the text, the figures and the data of what was measured."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

from vireport.scenario import Accuracy, Loaded
from vireport.study import (
    Study,
    Task,
    accuracy_data,
    analyse,
    compliance_data,
)
from vireport.trust import (
    COLUMNS,
    broken,
    plain,
)

if TYPE_CHECKING:
    from vireport.progress import Progress


def measured(loaded: Loaded, progress: Progress | None = None) -> Study:
    """Study a scenario with its accuracy block, or with the default one where it has none.

    Simulation and requirements are left out: they are not what is asked for here.
    """
    block = loaded.scenario.accuracy or Accuracy()
    changes = {"accuracy": block, "simulation": None, "requirements": None}
    scenario = loaded.scenario.model_copy(update=changes)
    return analyse(replace(loaded, scenario=scenario), (Task.PNG, Task.JSON), progress)


def text(study: Study, every: bool = False) -> str:
    """What was measured, for the terminal; with `every`, each run in a row."""
    parts = [plain(study.work, every).rstrip("\n")] if study.work is not None else []
    if study.compliance is not None:
        from vireport.report import plain_text

        lines = (broken(line, "    ") if len(line) > COLUMNS else line for line in plain_text(study.compliance))
        parts.append("\n".join(["Compliant membranes", "", *lines]))
    elif study.work is not None:
        why = next(step.why for step in study.plan.steps if step.task is Task.COMPLIANT)
        parts.append(f"Compliant membranes: left out ({why})")
    return "\n\n".join(parts) + "\n"


def data(study: Study) -> bytes:
    """What was measured, as JSON."""
    found = {
        "scenario_sha256": study.loaded.sha256,
        "accuracy": None if study.work is None else accuracy_data(study.work),
        "compliant": None if study.compliance is None else compliance_data(study.compliance),
    }
    return (json.dumps(found, indent=1, allow_nan=False) + "\n").encode()


def files(study: Study) -> dict[str, bytes]:
    """The figures and accuracy.json, by their names."""
    from vireport.figures import measured_pictures

    return {"accuracy.json": data(study), **{f"{drawn.name}.png": drawn.png for drawn in measured_pictures(study)}}
