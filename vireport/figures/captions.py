"""Captions and alternative texts of figures 2, 4 and 7, made from the numbers that they show."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from vireport.figures.curves import (
    Floats,
    PairedImpacts,
    Stretch,
    impact_pairs,
    stretches,
    swept_solution,
)
from vireport.motions import eigenvalues
from vireport.physics import Device
from vireport.scenario import Parameter
from vireport.study import Study, Task
from vireport.text import (
    AlertCode,
    capital,
    exact,
    quantity,
    scaled,
    significant,
)

TITLES = {
    Task.FIGURE_2: "Impact velocity, phase and flight time, as in the paper's Fig. 2",
    Task.FIGURE_4: "Discriminant and eigenvalues, as in the paper's Fig. 4",
    Task.FIGURE_7: "Generated voltage, as in the paper's Fig. 7",
}

CHARTS = {Task.FIGURE_2: "Three line charts", Task.FIGURE_4: "Two line charts", Task.FIGURE_7: "Line chart"}

LAMBDA_LIMIT = 1.6
"""Size of the eigenvalues up to which figure 4 shows them; beyond, how unstable a motion is does not matter."""

HUGE = 1e4
"""Size from which no number is given: eigenvalues grow without bound towards an impact without velocity."""

NEXT_TO_NOTHING = 1e-3
"""Share of the largest value below which another is called about 0."""

DIGITS = 8
"""Significant digits of inputs in figures: more than anyone gives, fewer than a search leaves."""

OUTSIDE = "outside the membrane's geometry: ranking only"
"""What is said of voltages where the deflections exceed the membrane."""

ABOUT = {
    Task.FIGURE_2: "Magnitude of the impact velocity |Ż| in units of F/(2 M f), phase φ of the force at the impact "
    "and flight time in forcing periods, for the impacts on the bottom and on the top membrane",
    Task.FIGURE_4: "Discriminant Δ = tr² − 4 det of the linearised return map and its eigenvalues λ₁ ≥ λ₂, or the real "
    "part that they share where Δ < 0",
    Task.FIGURE_7: "Voltage U_imp − U_in generated at each impact, and U_ave, the mean over both",
}
"""What is drawn, for any scenario."""


def conditions(study: Study, varied: Parameter | None = None) -> str:
    """What is held along the sweep, or while another parameter is varied."""
    return ", ".join(held(study, varied))


def held(study: Study, varied: Parameter | None = None) -> list[str]:
    """The parameters that are held along the sweep, each with its value and unit."""
    solution = study.solution
    swept = varied or (solution.parameter if solution.sweep else None)
    return held_by(solution.device, (swept,) if swept else ())


def held_by(device: Device, varied: Collection[str]) -> list[str]:
    """The parameters of a device but those that vary, by their keys."""
    parameters = [
        f"{name.symbol} = {name.show(value, DIGITS)}"
        for name in Parameter
        if name not in varied and (value := getattr(device, name)) is not None
    ]
    parameters.append(f"M = {exact(device.capsule_mass_kg)} kg")
    parameters += [f"r = {exact(device.restitution)}"] if "restitution" not in varied else []
    return parameters + ([f"n = {device.period_ratio}"] if device.period_ratio != 1 else [])


def caption(study: Study, figure: Task, simulated: PairedImpacts | None = None) -> str:
    """The caption of a figure: what is drawn, and what is to be known of the scenario for it."""
    remarks = [f"{conditions(study)}; {swept_range(study)}", *_remarks(study, figure)]
    return f"{ABOUT[figure]}. {'; '.join([*remarks, *_overlay(figure, simulated)])}."


def _remarks(study: Study, figure: Task) -> Iterator[str]:
    solution, swept = study.solution, study.solution.parameter
    if figure == Task.FIGURE_4:
        parts = stretches(solution)
        largest = max((float(np.abs(values).max()) for part in parts for values in _eigenvalues(part)), default=0.0)
        if largest > LAMBDA_LIMIT:
            yield f"|λ| reaches {significant(largest, 3)}" if largest < HUGE else f"|λ| exceeds {significant(HUGE)}"
        if _mirrored(study):
            yield "mirror images share one curve"
        return
    if figure == Task.FIGURE_2 and swept in (Parameter.LENGTH, Parameter.INCLINATION):
        yield f"F/(2 M f) = {significant(float(solution.device.velocity_unit(swept, 0.0)), 4)} m/s"
    if figure == Task.FIGURE_7 and solution.membrane is not None:
        membrane = solution.membrane
        yield f"m = {scaled(membrane.ball_mass_kg, 3)} g, U_in = {quantity(membrane.bias_voltage_v, 'V')}"
        if not solution.within_membrane:
            yield f"{OUTSIDE} ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY})"
    if _level(study):
        yield "both impacts of a motion are equally fast"
    if words := _doubled(study):
        yield f"thin: motions that come of period doublings ({', '.join(words)})"
    if figure == Task.FIGURE_2 and _mirrored(study):
        yield "each asymmetric motion is drawn with its mirror image"


def alt_text(study: Study, figure: Task, simulated: PairedImpacts | None = None) -> str:
    """A description of a figure for those who do not see it."""
    parts = stretches(study.solution)
    head = f"{CHARTS[figure]} over {swept_range(study)}"
    if not parts:
        return f"{head}, empty: there is no admissible 1:1 motion in the sweep."
    extents = [
        f"{word} motions: {_values(study, figure, chosen)}."
        for word, stable in (("Stable", True), ("Unstable", False))
        if (chosen := [part for part in parts if part.stable == stable])
    ]
    return " ".join(
        [f"{head}.", _stable(study), *extents, *_points(study), *map(_sentence, _overlay(figure, simulated))]
    )


def _doubled(study: Study) -> list[str]:
    """The words of the motions that the 1:1 motions become by period doublings."""
    found = [] if study.atlas is None else study.atlas.doubled(study.solution.device.period_ratio)
    return list(dict.fromkeys(family.word.letters for family in found))


def _level(study: Study) -> bool:
    """Whether gravity has no part along the capsule."""
    return study.solution.device.inclination_deg == 0 and study.solution.parameter is not Parameter.INCLINATION


def _mirrored(study: Study) -> bool:
    """Whether motions are drawn that are mirror images of others."""
    return any(part.branch.mirror_of is not None for part in stretches(study.solution))


def _overlay(figure: Task, simulated: PairedImpacts | None) -> list[str]:
    """What is drawn over the curves from the simulation, and how many points."""
    if simulated is None or not len(simulated.d) or figure == Task.FIGURE_4:
        return []
    if figure == Task.FIGURE_7 and simulated.voltages is None:
        return []
    impacts = sum(int((~np.isnan(speed)).sum()) for speed in simulated.pairs()[0])
    values = len(np.unique(simulated.sweep_value))
    at = f"{impacts} impacts of periodic motions at {values} value{'s' * (values != 1)} of the swept parameter"
    if figure == Task.FIGURE_7:
        return [f"circles: voltages of {at}, by simulation"]
    return [f"circles: {at}, by simulation"]


def swept_range(study: Study) -> str:
    """The range of the sweep."""
    _, sweep = swept_solution(study)
    start, end = (sweep.parameter.with_unit(exact(value)) for value in (sweep.start, sweep.end))
    return f"{sweep.parameter.symbol} from {start} to {end}"


def _stable(study: Study) -> str:
    ranges = study.solution.stable_ranges
    if not ranges:
        return "There is no stable admissible 1:1 motion in the sweep."
    return f"Stable 1:1 motion for {' and for '.join(part.inequality for part in ranges)}."


def _points(study: Study) -> list[str]:
    """The critical points with the swept parameter."""
    swept = study.solution.parameter
    points = [f"{point.label} {swept.show(point.point.sweep_value)}" for point in study.solution.critical_points]
    return [f"Critical points, at {swept.symbol}: {'; '.join(points)}."] if points else []


def _sentence(text: str) -> str:
    return f"{capital(text)}."


def _eigenvalues(part: Stretch) -> tuple[Floats, Floats]:
    return eigenvalues(part.branch.motions.trace[part.rows], part.branch.motions.restitution)


def _values(study: Study, figure: Task, parts: Sequence[Stretch]) -> str:
    """From where to where the quantities of a figure go."""
    if figure == Task.FIGURE_7:
        return f"average voltage {_extent([x.average_v[p.rows] for p in parts if (x := p.branch.voltages)], 'V')}"
    if figure == Task.FIGURE_4:
        discriminants = _extent([part.branch.motions.discriminant[part.rows] for part in parts])
        sizes = _extent([values for part in parts for values in _eigenvalues(part)])
        return f"discriminant {discriminants}, eigenvalues or their real parts {sizes}"
    pairs = [(part.rows, impact_pairs(part.branch.motions, study.solution.device.period_ratio)) for part in parts]
    return ", ".join(
        f"{quantity_name} at the {where} {_extent([pair[k][side][rows] for rows, pair in pairs])}"
        for k, quantity_name in enumerate(("impact speed", "phase", "flight time over two"))
        for side, where in enumerate(("bottom", "top"))
    )


def _extent(values: Sequence[Floats], unit: str = "") -> str:
    """A range in three digits, and no more of what is next to nothing beside the largest."""
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    texts = []
    for value in (low, high):
        rounded = float(f"{value:.3g}")
        text = quantity(rounded, unit, 3) if unit else exact(rounded)
        texts.append("about 0" if abs(value) < NEXT_TO_NOTHING * max(-low, high) else text)
    if high > HUGE and not unit:
        texts[1] = f"more than {significant(HUGE)}"
    return texts[0] if texts[0] == texts[1] else " to ".join(texts)
