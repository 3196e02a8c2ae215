"""Captions and alternative texts of the figures, made from the numbers that they show."""

from __future__ import annotations

import numpy as np

from vireport.analysis import Solution, Sweep, eigenvalues
from vireport.figures.curves import Floats, Simulated, Stretch, pairs, solved, stretches
from vireport.gate import (
    capital,
    range_text,
)
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import (
    MOST_DIGITS,
    exact,
    quantity,
    scaled,
    significant,
)

TITLES = {
    "figure-2": "Impact velocity, phase and flight time",
    "figure-4": "Discriminant and eigenvalues",
    "figure-7": "Generated voltage",
}

LAMBDA_LIMIT = 1.6
"""Size of the eigenvalues up to which figure 4 shows them; beyond, how unstable a motion is is of no use."""

HUGE = 1e4
"""Size from which eigenvalues are not told: they grow without bound towards an impact without velocity."""

EQUALLY_FAST = "In a horizontal capsule both impacts of a motion are equally fast"

OUTSIDE = "outside the membrane's geometry: ranking only"
"""What stands on the voltages where the deflections exceed the membrane."""


def conditions(study: Study, varied: Parameter | None = None) -> str:
    """What is held along the sweep, or while another parameter is varied: parameters with their units."""
    return ", ".join(held(study, varied))


def held(study: Study, varied: Parameter | None = None) -> list[str]:
    """The parameters that are held along the sweep, each with its value and unit."""
    solution = study.solution
    device, swept = solution.device, varied or (solution.parameter if solution.sweep else None)
    found = [
        f"{name.symbol} = {name.with_unit(exact(value))}"
        for name in Parameter
        if name != swept and (value := getattr(device, name)) is not None
    ]
    found += [f"M = {exact(device.capsule_mass_kg)} kg", f"r = {exact(device.restitution)}"]
    return found + ([f"n = {device.period_ratio}"] if device.period_ratio != 1 else [])


def column_caption(study: Study, name: str, simulated: Simulated | None = None) -> str:
    """What is to be said of one scenario where its figure stands beside those of others."""
    solution, sweep = solved(study)
    parts = [_setting(study, sweep), _stable(study), *_points(solution, sweep), *_overlay(name, simulated)]
    return " ".join(parts)


def outside_geometry(study: Study) -> bool:
    """Whether the voltages are evaluated at deflections that the membrane's geometry does not have."""
    return not study.solution.within_membrane


def beyond_limits(solution: Solution) -> str:
    """Which branches have eigenvalues that figure 4 does not show, and how large they become."""
    largest: dict[int, float] = {}
    family: dict[int, str] = {}
    for part in stretches(solution):
        motions = part.branch.motions
        size = float(np.abs(np.stack(eigenvalues(motions.trace[part.rows], motions.restitution))).max())
        number = part.branch.mirror_of or part.branch.number
        family[number] = part.branch.family
        largest[number] = max(size, largest.get(number, 0.0))
    found = [
        f"branch {number} ({family[number]}) "
        + (f"reaches |λ| = {significant(size, 3)}" if size < HUGE else f"goes beyond |λ| = {significant(HUGE)}")
        for number, size in sorted(largest.items())
        if size > LAMBDA_LIMIT
    ]
    return "; ".join(found)


def caption(study: Study, name: str, simulated: Simulated | None = None) -> str:
    """The caption of a figure: what is drawn and how, where it is stable, and the critical points."""
    solution, sweep = solved(study)
    about = {"figure-2": _about_2, "figure-4": _about_4, "figure-7": _about_7}[name](study)
    return " ".join(
        [
            *about,
            *_overlay(name, simulated),
            _setting(study, sweep),
            _stable(study),
            *_points(solution, sweep, name == "figure-2"),
            *_design(study, name),
        ]
    )


def alt_text(study: Study, name: str, simulated: Simulated | None = None) -> str:
    """A description of a figure for those who do not see it."""
    solution, sweep = solved(study)
    axis = _range(sweep)
    if sweep.parameter is not Parameter.INCLINATION:
        axis = f"d from {_apart(*(float(d) for d in sweep.coordinate_range))} ({axis})"
    kind = {"figure-2": "Three line charts", "figure-4": "Two line charts", "figure-7": "Line chart"}[name]
    parts = stretches(solution)
    if not parts:
        return f"{kind} over {axis}, empty: there is no admissible 1:1 motion in the sweep."
    values = {"figure-2": _values_2, "figure-4": _values_4, "figure-7": _values_7}[name]
    told = []
    for word, chosen in (
        ("stable", [p for p in parts if p.stable]),
        ("unstable", [p for p in parts if not p.stable]),
    ):
        if chosen:
            told.append(f"{capital(word)} motions: {values(study, chosen)}.")
    points = [*_points(solution, sweep), *_overlay(name, simulated)]
    return " ".join([f"{kind} over {axis}.", _stable(study), *told, *points])


def _about_2(study: Study) -> list[str]:
    device = study.solution.device
    unit = "F/(2 M f)"
    if study.solution.sweep and study.solution.parameter in (Parameter.LENGTH, Parameter.INCLINATION):
        unit += f" = {significant(float(device.velocity_unit(study.solution.parameter, 0.0)), 4)} m/s"
    about = [
        f"(a) Magnitude of the impact velocity |Ż| in units of {unit}, (b) phase φ of the force at the "
        "impact, (c) flight time over two Δt/2, which is the flight time in forcing periods.",
        "Blue and thick: impact k−1, on the bottom membrane, and the flight from it; green and thin: impact "
        "k, on the top one.",
        "Solid: stable; dash-dotted: unstable.",
    ]
    if _level(study):
        about.append(f"{EQUALLY_FAST}: blue and green coincide in (a).")
    if _mirrored(study):
        about.append("Each asymmetric motion is drawn together with its mirror image.")
    return about


def _about_4(study: Study) -> list[str]:
    solution, _ = solved(study)
    focus, modulus = (
        any(part.focus for part in stretches(solution)),
        significant(study.solution.device.restitution**2, 4),
    )
    about = [
        "(a) Discriminant Δ = tr² − 4 det of the linearised return map, (b) its eigenvalues λ₁ ≥ λ₂"
        + (f", and where Δ < 0 the real part that they share (thick; |λ| = r² = {modulus} there)." if focus else "."),
        "Solid: stable; dash-dotted: unstable. Red, thin: Δ = 0, λ = 0 and λ = ±1, the bounds of Table 1.",
    ]
    if _mirrored(study):
        about.append("Mirror images share one curve.")
    if beyond := beyond_limits(solution):
        about.append(f"|λ| > {LAMBDA_LIMIT} is off the axes: {beyond}.")
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
    if outside_geometry(study):
        about.append(f"The deflections are {OUTSIDE} (VR010).")
    return about


def _overlay(name: str, simulated: Simulated | None) -> list[str]:
    """What is drawn over the curves from the simulation, and how many points."""
    if simulated is None or not len(simulated.d) or name == "figure-4":
        return []
    if name == "figure-7" and simulated.voltages is None:
        return []
    impacts = sum(int((~np.isnan(speed)).sum()) for speed in simulated.pairs[0])
    values = len(np.unique(simulated.sweep_value))
    at = f"{impacts} impacts of periodic motions at {values} value{'s' * (values != 1)} of the swept parameter"
    if name == "figure-7":
        return [f"Simulation: circles, the voltages of {at}; stars, U_ave of each motion."]
    return [f"Circles: simulation, {at}."]


def _setting(study: Study, sweep: Sweep) -> str:
    swept = sweep.parameter
    return f"{conditions(study)}; {swept.symbol} from {_span(swept.show(sweep.start), swept.show(sweep.end))}."


def _range(sweep: Sweep) -> str:
    swept = sweep.parameter
    ends = (swept.with_unit(exact(end)) for end in (sweep.start, sweep.end))
    return f"{swept.symbol} from {_span(*ends)}"


def _stable(study: Study) -> str:
    if not study.solution.stable_ranges:
        return "There is no stable admissible 1:1 motion in the sweep."
    return f"Stable 1:1 motion for {' and for '.join(range_text(part) for part in study.solution.stable_ranges)}."


def _level(study: Study) -> bool:
    """Whether gravity has no part along the capsule."""
    return study.solution.device.inclination_deg == 0 and study.solution.parameter is not Parameter.INCLINATION


def _mirrored(study: Study) -> bool:
    """Whether motions are drawn that are mirror images of others."""
    return any(part.branch.mirror_of is not None for part in stretches(solved(study)[0]))


def _points(solution: Solution, sweep: Sweep, in_full: bool = False) -> list[str]:
    """The critical points with the swept parameter, or in full with their kind and d."""
    swept = sweep.parameter
    told = []
    for point in solution.critical_points:
        if not in_full:
            told.append(f"{point.label} {swept.show(point.point.sweep_value)}")
            continue
        at = f"{swept.symbol} = {swept.show(point.point.sweep_value)}"
        if swept is not Parameter.INCLINATION:
            at = f"d = {significant(point.point.d)}, {at}"
        told.append(f"{point.label} {point.kind.words} ({at})")
    head = "Critical points" if in_full else f"Critical points, at {swept.symbol}"
    return [f"{head}: {'; '.join(told)}."] if told else []


def _design(study: Study, name: str) -> list[str]:
    design = study.solution.design
    if design is None or study.solution.sweep is None or name == "figure-4":
        return []
    swept, motions = design.parameter, design.motions
    stable = np.flatnonzero(motions.stable)
    at = f"The vertical line is the design point {swept.symbol} = {swept.with_unit(exact(design.value))}"
    if not len(stable):
        return [f"{at}, where no motion is stable."]
    row = stable[0]
    if name == "figure-7" and design.voltages is not None:
        volts = quantity(float(design.voltages.average_v[row]), "V")
        return [f"{at}; its stable motion gives U_ave = {volts}."]
    pair = pairs(motions, study.solution.device.period_ratio)
    speed, phase, flight = (_and(float(bottom[row]), float(top[row])) for bottom, top in pair)
    return [f"{at}; its stable motion has |Ż| = {speed}, φ = {phase} rad and Δt/2 = {flight} at bottom and top."]


def _values_2(study: Study, parts: list[Stretch]) -> str:
    found = []
    chosen = [(part, pairs(part.branch.motions, study.solution.device.period_ratio)) for part in parts]
    for k, name in enumerate(("impact speed", "phase", "flight time over two")):
        for side, where in enumerate(("bottom", "top")):
            found.append(f"{name} at the {where} {_extent([p[k][side][part.rows] for part, p in chosen])}")
    return ", ".join(found)


def _values_4(study: Study, parts: list[Stretch]) -> str:
    delta = _extent([part.branch.motions.discriminant[part.rows] for part in parts])
    sizes = [
        np.stack(eigenvalues(part.branch.motions.trace[part.rows], part.branch.motions.restitution)).ravel()
        for part in parts
    ]
    return f"discriminant {delta}, eigenvalues or their real parts {_extent(sizes)}"


def _values_7(study: Study, parts: list[Stretch]) -> str:
    values = [x.average_v[part.rows] for part in parts if (x := part.branch.voltages) is not None]
    return f"average voltage {_extent(values, 'V')}"


def _extent(values: list[Floats], unit: str = "") -> str:
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    if high > HUGE and not unit:
        return f"{_rough(low, high, unit)} to more than {significant(HUGE)}"
    texts = [_rough(x, max(-low, high), unit) for x in (low, high)]
    return texts[0] if texts[0] == texts[1] else _span(*texts)


def _rough(value: float, largest: float, unit: str) -> str:
    """Three digits, and no more of what is next to nothing beside the largest."""
    if abs(value) < 1e-3 * largest:
        return "about 0"
    rounded = float(f"{value:.3g}")
    return quantity(rounded, unit, 3) if unit else exact(rounded)


def _and(one: float, two: float) -> str:
    return f"{significant(one, 4)} and {significant(two, 4)}"


def _apart(low: float, high: float) -> str:
    """A range with so many digits that its ends differ."""
    digits = next((k for k in range(4, MOST_DIGITS) if significant(low, k) != significant(high, k)), MOST_DIGITS)
    return _span(significant(low, digits), significant(high, digits))


def _span(low: str, high: str) -> str:
    return f"{low} to {high}"
