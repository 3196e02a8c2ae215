"""The paper's three sweeps solved, its numbers beside ours, and its motions simulated from the printed values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.progress import Progress
from vireport.base.records import brief
from vireport.figures.curves import swept_solution
from vireport.motions.stability import Stability
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import wrapped
from vireport.scenario.loading import Loaded, load
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.trajectories import Portrait, portrait
from vireport.study.checks.paper import (
    CASES,
    ComparedRow,
    PaperCase,
    PaperComparison,
    PrintedQuantity,
    compare_with_case,
)
from vireport.study.plan import Task, refuse_special
from vireport.study.study import Study, analyse
from vireport.text.formatting import OF_A_MODEL

FILES = {"horizontal": "horizontal.yaml", "inclined": "inclined.yaml", "forcing": "inclined-forcing.yaml"}
"""The scenario of each of the paper's sweeps."""

_PACKAGE = Path(__file__).parent
EXAMPLES = _PACKAGE if (_PACKAGE / FILES["horizontal"]).is_file() else _PACKAGE.parents[1] / "examples"
"""The folder of these: inside an installed package, or at the root of a checkout."""

STUDY_FORMATS = (Task.PNG,)
"""What decides which steps the studies run: those that figures need."""


class ReproducedPaper(Struct, frozen=True, eq=False):
    """The paper's sweeps by this program.

    Attributes
    ----------
    studies : tuple of Study
        One for each of `CASES`.
    compared : tuple of PaperComparison
        The printed numbers beside those of each study.
    portraits : tuple of Portrait
        The motions of Fig. 3, by simulation from the printed values.
    displacements : tuple of Portrait
        Those of Fig. 6, of which the second is printed without its values.
    overrides : tuple of str
        Values that replaced those of the paper's scenarios, as ``path=value``.
    """

    studies: tuple[Study, ...]
    compared: tuple[PaperComparison, ...]
    portraits: tuple[Portrait, ...]
    displacements: tuple[Portrait, ...]
    overrides: tuple[str, ...] = ()

    __repr__ = brief

    @property
    def rows(self) -> list[ComparedRow]:
        """All that the paper prints, and the critical points that it gives a letter alone."""
        return [row for one in self.compared for row in one.rows]

    def agreeing(self, agrees: bool | None) -> list[ComparedRow]:
        """The rows that agree with the print, that do not, or, with None, for which nothing is printed."""
        return [row for row in self.rows if row.agrees is agrees]

    @property
    def printed(self) -> int:
        """How many results the paper prints, also of motions that a changed device has not."""
        return sum(case.results for case in CASES)

    @property
    def intervals(self) -> tuple[int, int]:
        """Intervals of Table 1: how many are of the printed type, and how many there are in print."""
        rows = [types for one in self.compared for types in one.types]
        alike = sum(a is b for types in rows for a, b in zip(types.printed, types.ours, strict=False))
        return alike, sum(len(types.words) for case in CASES for types in case.types)

    @property
    def simulation_difference(self) -> float | None:
        """Largest difference in velocity [y_c] and phase [rad] between simulated and solved motions of Fig. 3.

        Of those with two impacts a period; None where the simulation comes to none of them.
        """
        differences = list(self._differences())
        return max(differences, default=None)

    def _differences(self) -> Iterator[float]:
        solved = {(row.of, row.quantity): row.ours for row in self.rows}
        motions = [motion for case in CASES for motion in case.motions]
        for motion, simulated in zip(motions, self.portraits, strict=True):
            cycle, velocity = simulated.attractor.cycle, solved.get((motion.figure, PrintedQuantity.VELOCITY))
            if cycle is not None and velocity is not None and cycle.word == "BT":
                first = int(np.argmax(cycle.wall == BOTTOM))
                phase = solved[motion.figure, PrintedQuantity.PHASE]
                yield abs(float(cycle.velocity[first]) - velocity)
                yield abs(wrapped(float(cycle.phase[first]) - phase))


def reproduce_paper(overrides: Sequence[str] = (), say: Progress = lambda what: None) -> ReproducedPaper:
    """Solve the paper's three sweeps and simulate its motions.

    Parameters
    ----------
    overrides : sequence of str
        Values that replace those of all three scenarios, as ``path=value``.
    say : callable
        Told each long step as it begins.

    Raises
    ------
    UsageError, ScenarioError
        Where an override cannot be used, or asks for another kind of device or sweep.
    NumericalError
        Where a changed scenario cannot be solved.
    """
    studies, compared = [], []
    scenarios = [_scenario(case, tuple(overrides)) for case in CASES]
    for case, loaded in zip(CASES, scenarios, strict=True):
        say(f"solving Fig. 2{case.panels}")
        study = analyse(loaded, STUDY_FORMATS)
        studies.append(study)
        compared.append(compare_with_case(study.solution, case))
    say("simulating the motions of Fig. 3 and 6")
    portraits = [portrait for case, study in zip(CASES, studies, strict=True) for portrait in _portraits(case, study)]
    symmetric, inclined, _, doubled = portraits
    printed = symmetric, *_asymmetric(studies[0], compared[0]), inclined, doubled
    return ReproducedPaper(tuple(studies), tuple(compared), tuple(portraits), printed, tuple(overrides))


def _scenario(case: PaperCase, overrides: tuple[str, ...]) -> Loaded:
    """One of the paper's scenarios with overrides, which change neither the kind of device nor the sweep."""
    loaded = load(EXAMPLES / FILES[case.name], overrides)
    refuse_special(loaded.scenario, "vireport paper")
    sweep = loaded.scenario.sweep
    if sweep is None or sweep.parameter is not case.parameter:
        raise UsageError(
            f"--set: the paper's sweep of Fig. 2{case.panels} is needed (allowed: sweep.from and sweep.to, with "
            f"sweep.parameter: {case.parameter})"
        )
    return loaded


def _portraits(case: PaperCase, study: Study) -> Iterator[Portrait]:
    """The motions of Fig. 3 on a sweep: what the simulation comes to from the printed impact on the bottom."""
    _, sweep = swept_solution(study)
    for motion in case.motions:
        value = float(sweep.value(float(motion.d)))
        start = Impact(BOTTOM, float(motion.velocity), float(motion.phi))
        groups = sweep.device.groups(sweep.parameter, value).as_floats()
        yield portrait(groups, [start], sweep.parameter.place(value, OF_A_MODEL), compiled=False)


def _asymmetric(study: Study, compared: PaperComparison) -> Iterator[Portrait]:
    """The stable asymmetric node of Fig. 6 (b), amid the interval of Table 1 that ends at C1: no values are printed."""
    solution = study.solution
    types = (types for types in compared.types if types.family is Symmetry.ASYMMETRIC)
    rows = [row for one in types for row in one.intervals if row.stability is Stability.STABLE_NODE]
    if rows:
        motions = next(branch.motions for branch in solution.branches if branch.number == rows[-1].branch)
        amid = (rows[-1].first_row + rows[-1].last_row) // 2
        start = Impact(BOTTOM, float(motions.velocity_bottom[amid]), float(motions.phi_bottom[amid]))
        value = float(motions.sweep_value[amid])
        groups = solution.device.groups(solution.parameter, value).as_floats()
        yield portrait(groups, [start], solution.parameter.place(value, OF_A_MODEL), compiled=False)
