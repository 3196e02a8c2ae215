"""What to change where a design does not work: of each input the nearest values with which it does, seen by a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import floor, inf, log10

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError, ScenarioError, UsageError
from vireport.base.progress import Progress
from vireport.design.lines import HIGHEST_RESTITUTION
from vireport.design.solution import solution_of
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.energy import Membrane
from vireport.scenario.loading import loads
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.designs import Designs
from vireport.study.judging.requirements import required, spared
from vireport.study.study import Study, analyse

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

VALUES = 200
"""Values of an input that are looked at on either side of the design."""

FARTHEST = 2.0
"""Times by which an input may change: what is farther is another design."""

TRIES = 5
"""Runs on either side of the design along an input: of the values that may work the 1st, 2nd, 4th, 8th and 16th."""

FIRST_PART = 48
"""Values, the nearest, that are looked at first: where a third of them may work, there are enough to be tried."""

FIRST_STEPS = 4
"""Where a motion is looked for value by value, that many of the doubled steps are taken at once."""

DIGITS = 4
"""Significant digits of a value to change to, rounded away from the design."""


class Change(Struct, frozen=True):
    """A value of one input with which the design works, all else as it is.

    Attributes
    ----------
    path, quantity, symbol, unit : str
        Of the input.
    value : float
    percent : float or None
        Of the design's value, by which it changes, signed; None where that is 0.
    """

    path: str
    quantity: str
    symbol: str
    unit: str
    value: float
    percent: float | None


def changes(study: Study, say: Progress | None = None) -> tuple[Change, ...] | None:
    """For a design that falls short, the nearest value of each input on either side that a run finds to work.

    Parameters
    ----------
    study : Study
    say : callable, optional
        Told each input as it is looked at.

    Returns
    -------
    tuple of Change, or None
        The smallest first, empty where none is found; None where nothing need be changed, or there is no design point.
    """
    if study.solution.design is None or not study.verdict.fails:
        return None
    helpful = list[Change]()
    for varied in study.solution.device.inputs:
        if say is not None:
            say(f"what to change: {varied.quantity}")
        helpful += _working_changes(study, varied)
    return tuple(sorted(helpful, key=lambda change: inf if change.percent is None else abs(change.percent)))


def _working_changes(study: Study, varied: DesignInput) -> Iterator[Change]:
    present = float(study.solution.device.value_of(varied))
    for values in _sides(varied, present):
        for value in _tried(values[may_work(study, varied, values)]):
            rounded = rounded_away(value, present)
            if works(study, varied, rounded):
                percent = 100 * (rounded / present - 1) if present else None
                yield Change(varied.path, varied.quantity, varied.symbol, varied.unit, rounded, percent)
                break


def _sides(varied: DesignInput, value: float) -> tuple[Floats, Floats]:
    """Values below and above the design, the nearest first, as far as they may go."""
    low, high = varied.limits
    high = HIGHEST_RESTITUTION if varied in RESTITUTIONS else high
    steps = np.arange(1, VALUES + 1) / VALUES
    if varied is DesignInput.INCLINATION:  # a horizontal capsule has no per cent of its angle
        below, above = value - value * steps, value + (high - value) * steps
    else:
        below, above = value * FARTHEST**-steps, value * FARTHEST**steps
    return below[below >= low], above[above <= high]


def _tried(values: Floats) -> Iterator[float]:
    """The first of some values, the second, the fourth, ...: what arrays cannot tell may hold for a while."""
    for k in _doubled(len(values))[:TRIES]:
        yield float(values[k])


def _doubled(count: int) -> list[int]:
    """Rows 0, 1, 3, 7, ... of so many."""
    return [2**k - 1 for k in range(count.bit_length())]


def may_work(study: Study, varied: DesignInput, values: Floats) -> Mask:
    """Which values may work, by what arrays of designs tell, as many of the nearest as are tried.

    The values come nearest first, and the first part of them mostly has enough: the others are then not looked at.
    """
    kept, requirements = np.zeros(len(values), dtype=bool), study.scenario.requirements
    required_1_1 = requirements is None or not requirements.allowed
    try:
        for part in (slice(FIRST_PART), slice(FIRST_PART, None)):
            if kept.sum() < 2 ** (TRIES - 1):
                kept[part] = _arrays_tell(study, varied, values[part], required_1_1)
    except (NumericalError, UsageError):  # of a restitution that falls with speed there are no arrays
        return _one_by_one(study.solution.device, varied, values, required_1_1)
    return kept


def _arrays_tell(study: Study, varied: DesignInput, values: Floats, required_1_1: bool) -> Mask:
    """Which values may work; all others surely do not."""
    scenario, membrane = study.scenario, Membrane.of(study.scenario)
    changed = study.solution.device.with_values({varied: values})
    designs = Designs(scenario, changed, membrane and membrane.of_device(changed), len(values))
    kept = designs.has_motion() if required_1_1 else np.ones(len(values), dtype=bool)
    for requirement, limit in required(scenario):
        kept &= requirement.quantity.may_meet(designs, limit)
    return kept


def _one_by_one(device: Device, varied: DesignInput, values: Floats, required_1_1: bool) -> Mask:
    """Which values may work, where no arrays tell: the nearest at which a stable 1:1 motion begins, and some beyond.

    A value takes some 20 ms, so that it is looked for in ever longer steps, and then between two of these.
    """
    kept = np.zeros(len(values), dtype=bool)
    looked_at = _doubled(len(values))[FIRST_STEPS:]
    if not required_1_1:
        kept[looked_at] = True
        return kept
    below = -1
    for k in looked_at:
        if _has_motion(device, varied, values[k]):
            above = k
            while above - below > 1:
                middle = (below + above) // 2
                below, above = (below, middle) if _has_motion(device, varied, values[middle]) else (middle, above)
            kept[[above, *(row for row in looked_at if row > above)]] = True
            break
        below = k
    return kept


def _has_motion(device: Device, varied: DesignInput, value: float) -> bool:
    changed = device.with_values({varied: float(value)})
    try:
        design = solution_of(changed, None, None, design=True, margins=False).design
    except (NumericalError, UsageError):  # of which nothing can be said
        return False
    return design is not None and bool(design.motions.stable_mask.any())


def rounded_away(value: float, present: float) -> float:
    """A value with few digits, no nearer to the design.

    Examples
    --------
    >>> rounded_away(0.6612345, 0.6), rounded_away(0.5512345, 0.6), rounded_away(0.5, 0.6)
    (0.6613, 0.5512, 0.5)
    """
    if value == 0:
        return value
    unit = 10.0 ** (floor(log10(abs(value))) - DIGITS + 1)
    steps = value / unit
    whole = np.ceil(steps - 1e-9) if value > present else np.floor(steps + 1e-9)
    return float(f"{whole * unit:.{DIGITS}g}")


def works(study: Study, varied: DesignInput, value: float) -> bool:
    """Whether a run of the design with another value does not fall short.

    What takes long to judge comes last: most values fall short of something else, which refuses them whatever a search
    for shocks would give.
    """
    pairs = list(required(study.scenario))
    needless = spared(pairs)
    dear = [f"requirements.{key}" for requirement, _ in pairs if requirement.dear for key in requirement.keys]
    if not dear:
        return _works_without(study, needless, varied, value)
    # A block in which nothing is required would be refused.
    last = dear if any(not requirement.dear for requirement, _ in pairs) else ["requirements"]
    return all(_works_without(study, parts, varied, value) for parts in ([*needless, *last], needless))


def _works_without(study: Study, parts: Iterable[str], varied: DesignInput, value: float) -> bool:
    """Whether a run without some blocks or keys of the scenario does not fall short."""
    loaded = study.loaded
    overrides = (*loaded.overrides, *(f"{part}=" for part in parts), f"{varied.path}={value!r}")
    try:
        other = analyse(loads(loaded.document.text, loaded.document.name, overrides), ())
    except (NumericalError, ScenarioError, UsageError):  # a value of which nothing can be said
        return False
    return not other.verdict.fails
