"""All extreme cases around a device."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vireport.base.errors import NumericalError
from vireport.base.progress import WorkStep
from vireport.design.solution import SMALLEST_LOSS
from vireport.physics.device import RESTITUTIONS
from vireport.scenario.loading import Loaded
from vireport.verify.critical import critical_rows
from vireport.verify.harvester import harvester_of
from vireport.verify.motions import motion_rows
from vireport.verify.rows import Case, CaseOutcome, run

if TYPE_CHECKING:
    from vireport.base.progress import Progress


def catalogue(loaded: Loaded | None = None) -> tuple[Case, ...]:
    """Every case around the device of a scenario, or around the paper's.

    Raises
    ------
    NumericalError
        If the device is itself one of those that are refused.
    """
    harvester = harvester_of(loaded)
    for varied in (varied for varied in harvester.device.inputs if varied in RESTITUTIONS):
        value = harvester.device.value_of(varied)
        if 1 - value < SMALLEST_LOSS:
            raise NumericalError(
                f"{varied.path}: {value!r} is itself an extreme that is refused: impacts "
                f"with hardly any loss (allowed here: at most 1 - {SMALLEST_LOSS:g})"
            )
    return (*motion_rows(harvester), *critical_rows(harvester))


def run_catalogue(loaded: Loaded | None = None, progress: Progress | None = None) -> tuple[CaseOutcome, ...]:
    """Run every case around the device of a scenario, or around the paper's; `progress` is called with each."""
    outcomes, rows, say = [], catalogue(loaded), progress or (lambda what: None)
    for k, row in enumerate(rows):
        say(WorkStep(row.title, k / len(rows)))
        outcomes.append(run(row))
    return tuple(outcomes)
