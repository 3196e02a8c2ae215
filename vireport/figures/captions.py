"""Title, caption and alternative text of each figure, in the words of ``templates/words/figures/``.

Here are the numbers that figures 2, 4 and 7 are told by, and what is held along a sweep.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from msgspec import Struct

from vireport.figures.curves import (
    Floats,
    PairedImpacts,
    Stretch,
    impact_pairs,
    stretches,
    swept_solution,
)
from vireport.figures.style import Picture
from vireport.motions.stability import eigenvalues
from vireport.physics.device import RESTITUTIONS, Device
from vireport.scenario.blocks import Approach
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter
from vireport.study.plan import AnyTask, Task
from vireport.study.study import Study
from vireport.text.formatting import exact, stated_text
from vireport.text.templates import Words

LAMBDA_LIMIT = 1.6
"""Size of the eigenvalues up to which figure 4 shows them; beyond, how unstable a motion is does not matter."""

FILES = {
    Task.FIGURE_ANSWER: "answer",
    Task.FIGURE_2: "sweep",
    Task.FIGURE_4: "sweep",
    Task.FIGURE_7: "sweep",
    Task.FIGURE_3: "portraits",
    Task.FIGURE_6: "portraits",
    Task.FIGURE_PORTRAITS: "portraits",
    Task.FIGURE_DIAGRAM: "diagram",
    Task.FIGURE_HYSTERESIS: "hysteresis",
    Task.FIGURE_ATLAS: "atlas",
    Task.FIGURE_LADDER: "atlas",
    Task.FIGURE_DEVICE: "device",
    Task.FIGURE_MARGINS: "margins",
    Task.FIGURE_CYCLE: "cycle",
}
"""Templates of the words of each figure of the core; those of figures that are not drawn are not read."""


def pictured(name: AnyTask, facts: Mapping[str, object], figure: Figure, templates: Path | None = None) -> Picture:
    """Give a figure its title, caption and alternative text.

    Parameters
    ----------
    name : Task or AddedTask
        Of an addition, the words are in the file that is named as the figure, without ``figure-``.
    facts : mapping
        What the macros of the figure know as ``x``.
    figure : Figure
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    caption, alt = _said(name, "caption", templates, facts), alt_text(name, facts, templates)
    return Picture(name, title_of(name, templates), caption, alt, figure)


def alt_text(name: AnyTask, facts: Mapping[str, object], templates: Path | None = None) -> str:
    """A description of what a figure shows for those who do not see it."""
    return _said(name, "alt", templates, facts)


def title_of(name: AnyTask, templates: Path | None = None) -> str:
    """The title of a figure, from its file of words."""
    return _said(name, "title", templates)


def about(name: Task, templates: Path | None = None) -> str:
    """What figure 2, 4 or 7 shows, for any scenario."""
    return _said(name, "about", templates)


def _said(name: AnyTask, part: str, templates: Path | None, *facts: Mapping[str, object]) -> str:
    file = FILES[name] if isinstance(name, Task) else name.removeprefix("figure-")
    return Words(f"figures/{file}", templates)(f"{name.replace('-', '_')}_{part}", *facts)


def conditions(study: Study, varied: Parameter | None = None) -> str:
    """The parameters held along the sweep, or while another one is varied, in one line."""
    return ", ".join(held(study, varied))


def held(study: Study, varied: Parameter | None = None) -> list[str]:
    """The parameters that are held along the sweep, each with its value and unit."""
    solution = study.solution
    swept = varied or (solution.parameter if solution.sweep else None)
    return held_by(solution.device, (swept,) if swept else ())


def held_by(device: Device, varied: Collection[str]) -> list[str]:
    """The parameters of a device but those that vary, by their keys."""
    parameters = [
        name.place(value) for name in DRIVING if name not in varied and (value := getattr(device, name)) is not None
    ]
    if DesignInput.CAPSULE_MASS not in varied:
        parameters.append(f"M = {exact(device.capsule_mass_kg)} kg")
    if device.recoils and "ball_mass_kg" not in varied:
        parameters.append(f"m = {exact(device.ball_mass_kg, 3)} g, capsule free")
    parameters += _restitutions(device, varied)
    parameters += harmonics_of(device)
    parameters += friction_of(device)
    return parameters + ([f"n = {device.period_ratio}"] if device.period_ratio != 1 else [])


def restitutions_of(device: Device) -> list[str]:
    """The restitution of both membranes, or of each, as text."""
    return _restitutions(device, ())


def friction_of(device: Device) -> list[str]:
    """The friction of the ball as text, if there is any."""
    return [f"friction {stated_text(device.friction)}"] if device.friction else []


def harmonics_of(device: Device) -> list[str]:
    """The harmonics of the force as text."""
    return [
        f"harmonic {harmonic.order}: {stated_text(100 * harmonic.share)} %, {stated_text(harmonic.phase_deg)}°"
        for harmonic in device.harmonics
    ]


def _restitutions(device: Device, varied: Collection[str]) -> list[str]:
    """The restitutions that are held; where that of one membrane varies the other's, and neither where both do."""
    specified = [name for name in device.inputs if name in RESTITUTIONS]
    if moved := [name for name in RESTITUTIONS if name in varied]:
        specified = [name for name in RESTITUTIONS[1:] if name not in moved and RESTITUTIONS[0] not in moved]
    law = device.law
    falls = "" if law is None else f" (v/{exact(law.speed)} m/s)^{exact(law.exponent)}"
    return [f"{name.symbol} = {exact(device.value_of(name))}{falls}" for name in specified]


def swept_range(study: Study) -> str:
    """The range of the sweep, with its symbol and unit."""
    _, sweep = swept_solution(study)
    start, end = (sweep.parameter.with_unit(exact(value)) for value in (sweep.start, sweep.end))
    return f"{sweep.parameter.symbol} from {start} to {end}"


class Extent(Struct, frozen=True):
    """The least and largest value of a quantity of a figure, and its membrane, if it is one of an impact."""

    quantity: str
    low: float
    high: float
    unit: str = ""
    where: str = ""


class Circles(Struct, frozen=True):
    """How many simulated impacts are drawn over the curves, at how many values, and whether of balls from rest."""

    impacts: int
    values: int
    from_rest: bool


class MeasuredPoints(Struct, frozen=True):
    """What was measured, as a figure shows it: values of the swept parameter, the words there, and what has none.

    Attributes
    ----------
    values : int
        At which something was measured that is known.
    words : tuple of str
        Of what repeats itself, each once.
    loose : int
        Values at which it does not.
    ways : bool
        Whether it was measured upwards and downwards.
    """

    values: int
    words: tuple[str, ...]
    loose: int
    ways: bool


def measured_caption(study: Study) -> str:
    """What of the measured impacts is in a figure, in words; "" where nothing is."""
    drawable = [at for at in study.measured if at.measured is not None]
    if not drawable:
        return ""
    words = dict.fromkeys(at.motion.word.letters for at in drawable if at.motion is not None)
    loose = sum(at.motion is None for at in drawable)
    ways = {Approach.UP, Approach.DOWN} <= {at.direction for at in drawable}
    return Words("measured")("points", MeasuredPoints(len(drawable), tuple(words), loose, ways))


def caption_facts(study: Study, figure: Task, simulated: PairedImpacts | None = None) -> dict[str, object]:
    """What figure 2, 4 or 7 shows of a study, for its words."""
    solution, parts = study.solution, stretches(study.solution)
    swept, membrane = solution.parameter, solution.membrane
    largest = max((float(np.abs(values).max()) for part in parts for values in _eigenvalues(part)), default=0.0)
    scaled = swept in (Parameter.LENGTH, Parameter.INCLINATION)
    return {
        "held": held(study),
        "range": swept_range(study),
        "swept": swept,
        "ranges": study.verdict.inequalities,
        "points": solution.critical_points,
        "exactness": study.evidence.exactness,
        "kinds": sorted({point.event for point in solution.critical_points}, key=lambda kind: kind.letter),
        "extents": list(_extents(study, figure, parts)),
        "mirrored": any(part.branch.mirror_of is not None for part in parts),
        "level": solution.device.inclination_deg == 0 and swept is not Parameter.INCLINATION,
        "doubled": _doubled(study),
        "from_rest": _share_from_rest(study),
        "unit_m_s": float(solution.device.velocity_unit(swept, 0.0)) if scaled else None,
        "largest": largest if largest > LAMBDA_LIMIT else None,
        "ball_mass_kg": membrane.ball_mass_kg if membrane is not None else None,
        "bias_v": membrane.bias_voltage_v if membrane is not None else None,
        "simulated": _circles(study, figure, simulated),
        "measured": measured_caption(study),
    }


def _share_from_rest(study: Study) -> float | None:
    """Share of the sweep on which the ball comes to a 1:1 motion from rest; None where that was not looked for."""
    over_sweep = study.switched_on.over_sweep if study.switched_on is not None else ()
    if not over_sweep:
        return None
    reached = sum(stretch.end - stretch.start for stretch in over_sweep if stretch.outcome.is_one_to_one)
    return reached / (over_sweep[-1].end - over_sweep[0].start)


def _doubled(study: Study) -> list[str]:
    """The words of the motions that the 1:1 motions become by period doublings."""
    families = [] if study.atlas is None else study.atlas.doubled(study.solution.device.period_ratio)
    return list(dict.fromkeys(family.word.letters for family in families))


def _circles(study: Study, figure: Task, simulated: PairedImpacts | None) -> Circles | None:
    """The simulated points drawn over the curves of a figure, as its caption counts them; None where there are none."""
    if simulated is None or not len(simulated.d) or (figure == Task.FIGURE_7 and simulated.voltages is None):
        return None
    impacts = sum(int((~np.isnan(speed)).sum()) for speed in simulated.pairs()[0])
    return Circles(impacts, len(np.unique(simulated.sweep_value)), study.crosscheck is None)


def _eigenvalues(part: Stretch) -> tuple[Floats, Floats]:
    motions = part.branch.motions.select(part.rows)
    return eigenvalues(motions.trace, motions.decay)


def _extents(study: Study, figure: Task, parts: Sequence[Stretch]) -> Iterator[tuple[bool, list[Extent]]]:
    """From where to where the quantities of a figure go, for the stable motions and for the others."""
    ratio = study.solution.device.period_ratio
    for stable in (True, False):
        if chosen := [part for part in parts if part.stable == stable]:
            yield stable, list(_of_motions(figure, chosen, ratio))


def _of_motions(figure: Task, parts: Sequence[Stretch], period_ratio: int) -> Iterator[Extent]:
    if figure == Task.FIGURE_7:
        volts = [
            part.branch.voltages_by_motion.average_v[part.rows]
            for part in parts
            if part.branch.voltages_by_motion is not None
        ]
        yield Extent("average", *_ends(volts), "V")
    elif figure == Task.FIGURE_4:
        yield Extent("discriminant", *_ends([part.branch.motions.discriminant[part.rows] for part in parts]))
        yield Extent("eigenvalues", *_ends([values for part in parts for values in _eigenvalues(part)]))
    else:
        pairs = [(part.rows, impact_pairs(part.branch.motions, period_ratio)) for part in parts]
        for k, quantity in enumerate(("speed", "phase", "flight")):
            for side, where in enumerate(("bottom", "top")):
                ends = _ends([pair[k][side][rows] for rows, pair in pairs])
                yield Extent(quantity, *ends, where=where)


def _ends(values: Sequence[Floats]) -> tuple[float, float]:
    return min(float(v.min()) for v in values), max(float(v.max()) for v in values)
