"""Captions and alternative texts of figures 2, 4 and 7, made from the numbers that they show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vireport.alerts import AlertCode
from vireport.analysis import eigenvalues
from vireport.figures.curves import Floats, Simulated, Stretch, impact_pairs, stretches, swept_solution
from vireport.gate import range_text
from vireport.scenario import Parameter
from vireport.study import Study, Task
from vireport.text import exact, quantity, scaled, significant

TITLES = {
    Task.FIGURE_2: "Impact velocity, phase and flight time",
    Task.FIGURE_4: "Discriminant and eigenvalues",
    Task.FIGURE_7: "Generated voltage",
}

CHARTS = {Task.FIGURE_2: "Three line charts", Task.FIGURE_4: "Two line charts", Task.FIGURE_7: "Line chart"}

LAMBDA_LIMIT = 1.6
"""Size of the eigenvalues up to which figure 4 shows them; beyond, how unstable a motion is does not matter."""

HUGE = 1e4
"""Size from which no number is given: eigenvalues grow without bound towards an impact without velocity."""

NEXT_TO_NOTHING = 1e-3
"""Share of the largest value below which another is called about 0."""

OUTSIDE = "outside the membrane's geometry: ranking only"
"""What is said of voltages where the deflections exceed the membrane."""

EQUALLY_FAST = "In a horizontal capsule both impacts of a motion are equally fast"


def conditions(study: Study, varied: Parameter | None = None) -> str:
    """What is held along the sweep, or while another parameter is varied."""
    return ", ".join(held(study, varied))


def held(study: Study, varied: Parameter | None = None) -> list[str]:
    """The parameters that are held along the sweep, each with its value and unit."""
    solution = study.solution
    device, swept = solution.device, varied or (solution.parameter if solution.sweep else None)
    parameters = [
        f"{name.symbol} = {name.with_unit(exact(value))}"
        for name in Parameter
        if name != swept and (value := getattr(device, name)) is not None
    ]
    parameters += [f"M = {exact(device.capsule_mass_kg)} kg", f"r = {exact(device.restitution)}"]
    return parameters + ([f"n = {device.period_ratio}"] if device.period_ratio != 1 else [])


def caption(study: Study, figure: Task, simulated: Simulated | None = None) -> str:
    """The caption of a figure: what is drawn and how, where it is stable, and the critical points."""
    about = {Task.FIGURE_2: _about_2, Task.FIGURE_4: _about_4, Task.FIGURE_7: _about_7}[figure](study)
    setting = f"{conditions(study)}; {_range(study)}."
    points = _points(study, in_full=figure == Task.FIGURE_2)
    return " ".join([*about, *_overlay(figure, simulated), setting, _stable(study), *points, *_design(study, figure)])


def column_caption(study: Study, figure: Task, simulated: Simulated | None = None) -> str:
    """What is to be said of one scenario where its figure stands beside those of others."""
    setting = f"{conditions(study)}; {_range(study)}."
    return " ".join([setting, _stable(study), *_points(study), *_overlay(figure, simulated)])


def alt_text(study: Study, figure: Task, simulated: Simulated | None = None) -> str:
    """A description of a figure for those who do not see it."""
    parts = stretches(study.solution)
    head = f"{CHARTS[figure]} over {_range(study)}"
    if not parts:
        return f"{head}, empty: there is no admissible 1:1 motion in the sweep."
    extents = [
        f"{word} motions: {_values(study, figure, chosen)}."
        for word, stable in (("Stable", True), ("Unstable", False))
        if (chosen := [part for part in parts if part.stable == stable])
    ]
    return " ".join([f"{head}.", _stable(study), *extents, *_points(study), *_overlay(figure, simulated)])


def _about_2(study: Study) -> list[str]:
    device, swept = study.solution.device, study.solution.parameter
    unit = "F/(2 M f)"
    if swept in (Parameter.LENGTH, Parameter.INCLINATION):
        unit += f" = {significant(float(device.velocity_unit(swept, 0.0)), 4)} m/s"
    about = [
        f"(a) Magnitude of the impact velocity |Ż| in units of {unit}, (b) phase φ of the force at the impact, "
        "(c) flight time over two Δt/2, which is the flight time in forcing periods. Blue and thick: impact k−1, on "
        "the bottom membrane, and the flight from it; green and thin: impact k, on the top one. Solid: stable; "
        "dash-dotted: unstable."
    ]
    if _level(study):
        about.append(f"{EQUALLY_FAST}: blue and green coincide in (a).")
    if _mirrored(study):
        about.append("Each asymmetric motion is drawn together with its mirror image.")
    return about


def _about_4(study: Study) -> list[str]:
    solution = study.solution
    parts = stretches(solution)
    real_part = "."
    if any(part.focus for part in parts):
        modulus = significant(solution.device.restitution**2, 4)
        real_part = f", and where Δ < 0 the real part that they share (thick; |λ| = r² = {modulus} there)."
    about = [
        f"(a) Discriminant Δ = tr² − 4 det of the linearised return map, (b) its eigenvalues λ₁ ≥ λ₂{real_part} "
        "Solid: stable; dash-dotted: unstable. Red, thin: Δ = 0, λ = 0 and λ = ±1, the bounds of Table 1."
    ]
    if _mirrored(study):
        about.append("Mirror images share one curve.")
    largest = max((float(np.abs(values).max()) for part in parts for values in _eigenvalues(part)), default=0.0)
    if largest > LAMBDA_LIMIT:
        reach = f"reaches {significant(largest, 3)}" if largest < HUGE else f"exceeds {significant(HUGE)}"
        about.append(f"|λ| {reach}; beyond {LAMBDA_LIMIT} it is off the axes.")
    return about


def _about_7(study: Study) -> list[str]:
    membrane = study.solution.membrane
    about = [
        "Red and thick: U_ave, the mean over both impacts; blue: U_imp − U_in at the bottom membrane (solid) "
        "and at the top one (dashed); dotted where the motion is unstable, more sparsely at the top.",
    ]
    if membrane is not None:
        bias = quantity(membrane.bias_voltage_v, "V")
        about.append(f"Ball mass m = {scaled(membrane.ball_mass_kg, 3)} g, bias U_in = {bias}.")
    if _level(study):
        about.append(f"{EQUALLY_FAST}: the three curves coincide.")
    if not study.solution.within_membrane:
        about.append(f"The deflections are {OUTSIDE} ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY}).")
    return about


def _level(study: Study) -> bool:
    """Whether gravity has no part along the capsule."""
    return study.solution.device.inclination_deg == 0 and study.solution.parameter is not Parameter.INCLINATION


def _mirrored(study: Study) -> bool:
    """Whether motions are drawn that are mirror images of others."""
    return any(part.branch.mirror_of is not None for part in stretches(study.solution))


def _overlay(figure: Task, simulated: Simulated | None) -> list[str]:
    """What is drawn over the curves from the simulation, and how many points."""
    if simulated is None or not len(simulated.d) or figure == Task.FIGURE_4:
        return []
    if figure == Task.FIGURE_7 and simulated.voltages is None:
        return []
    impacts = sum(int((~np.isnan(speed)).sum()) for speed in simulated.pairs[0])
    values = len(np.unique(simulated.sweep_value))
    at = f"{impacts} impacts of periodic motions at {values} value{'s' * (values != 1)} of the swept parameter"
    if figure == Task.FIGURE_7:
        return [f"Simulation: circles, the voltages of {at}; stars, U_ave of each motion."]
    return [f"Circles: simulation, {at}."]


def _range(study: Study) -> str:
    _, sweep = swept_solution(study)
    start, end = (sweep.parameter.with_unit(exact(value)) for value in (sweep.start, sweep.end))
    return f"{sweep.parameter.symbol} from {start} to {end}"


def _stable(study: Study) -> str:
    ranges = study.solution.stable_ranges
    if not ranges:
        return "There is no stable admissible 1:1 motion in the sweep."
    return f"Stable 1:1 motion for {' and for '.join(map(range_text, ranges))}."


def _points(study: Study, in_full: bool = False) -> list[str]:
    """The critical points with the swept parameter, or in full with their kind and d."""
    swept = study.solution.parameter
    points = []
    for point in study.solution.critical_points:
        at = swept.show(point.point.sweep_value)
        if in_full:
            d = "" if swept is Parameter.INCLINATION else f"d = {significant(point.point.d)}, "
            points.append(f"{point.label} {point.kind.words} ({d}{swept.symbol} = {at})")
        else:
            points.append(f"{point.label} {at}")
    head = "Critical points" if in_full else f"Critical points, at {swept.symbol}"
    return [f"{head}: {'; '.join(points)}."] if points else []


def _design(study: Study, figure: Task) -> list[str]:
    design = study.solution.design
    if design is None or figure == Task.FIGURE_4:
        return []
    swept, motions = design.parameter, design.motions
    at = f"The vertical line is the design point {swept.symbol} = {swept.with_unit(exact(design.value))}"
    stable = np.flatnonzero(motions.stable)
    if not len(stable):
        return [f"{at}, where no motion is stable."]
    row = stable[0]
    if figure == Task.FIGURE_7 and design.voltages is not None:
        return [f"{at}; its stable motion gives U_ave = {quantity(float(design.voltages.average_v[row]), 'V')}."]
    pairs = impact_pairs(motions, study.solution.device.period_ratio)
    speed, phase, flight = (" and ".join(significant(float(side[row]), 4) for side in pair) for pair in pairs)
    return [f"{at}; its stable motion has |Ż| = {speed}, φ = {phase} rad and Δt/2 = {flight} at bottom and top."]


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
