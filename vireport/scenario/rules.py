"""What must hold between several keys of a scenario, checked on the tree as it was read.

Not part of the validation of single values: it would come to such rules only once every value is right, and
then a reader would be told of his mistakes in two instalments.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from vireport.scenario.blocks import LARGEST, SMALLEST, SWEEPABLE, Membrane


class Finding(NamedTuple):
    """Something wrong at a path. `kind` is pydantic's word for it, or one of ours.

    Ours are "sweep_range", where the value is out of the range of the parameter that is swept, and "rule",
    where `value` is the message itself.
    """

    path: str
    kind: str
    value: object = None


def check(data: dict[str, Any], wrong: Collection[str], bare: Collection[str] = ()) -> list[Finding]:
    """Find what does not fit together.

    Parameters
    ----------
    data : dict
        The tree.
    wrong : collection of str
        Paths that are wrong in themselves: they are not compared with anything.
    bare : collection of str
        Paths in the file with nothing behind their colon.
    """
    tree = _Tree(data, wrong, bare)
    rules = (_required, _masses, _radii, _sweep, _simulation, _accuracy, _requirements, _title)
    return [finding for rule in rules for finding in rule(tree)]


class _Tree:
    def __init__(self, data: dict[str, Any], wrong: Collection[str], bare: Collection[str]) -> None:
        self.data, self.wrong, self.bare = data, wrong, bare

    def at(self, path: str) -> Any:
        node: Any = self.data
        for step in path.split("."):
            node = node.get(step) if isinstance(node, dict) else None
        return node

    def absent(self, path: str) -> bool:
        """Whether a key is not given, and not for a mistake in it or in a block around it."""
        return self.at(path) is None and not any(path == w or path.startswith(f"{w}.") for w in self.wrong)

    def number(self, path: str) -> float | None:
        value = self.at(path)
        return None if path in self.wrong or type(value) not in (int, float) else float(value)


def _required(tree: _Tree) -> Iterator[Finding]:
    if tree.at("sweep") is None:
        swept = None
    else:
        swept = tree.at("sweep.parameter")
        if not isinstance(swept, str) or swept not in SWEEPABLE:
            return  # which one is swept is not known, so neither is which ones are required
    for parameter, path in SWEEPABLE.items():
        block = path.rpartition(".")[0]
        present = isinstance(tree.at(block), dict) if block else True
        if parameter != swept and present and tree.at(path) is None:
            yield Finding(path, "missing")


def _masses(tree: _Tree) -> Iterator[Finding]:
    if isinstance(tree.at("device.membrane"), dict) and tree.at("device.ball_mass_kg") is None:
        needs = "ball_mass_kg is required where energy is evaluated (give it in device, or delete this block)"
        yield Finding("device.membrane", "rule", needs)
    ball, capsule = tree.number("device.ball_mass_kg"), tree.number("device.capsule_mass_kg")
    if ball is not None and capsule is not None and ball >= capsule:
        limit = f"below capsule_mass_kg, {capsule:.12g}: the capsule is assumed not to feel the ball"
        yield Finding("device.ball_mass_kg", "rule", f"got {ball:.12g}, which is too large ({limit})")


def _radii(tree: _Tree) -> Iterator[Finding]:
    ball, active = "device.membrane.ball_radius_m", "device.membrane.active_radius_m"
    if not isinstance(tree.at("device.membrane"), dict):
        return
    sizes = []
    for path in (ball, active):
        default = getattr(Membrane(), path.rpartition(".")[2])
        sizes.append(default if tree.at(path) is None and path not in tree.wrong else tree.number(path))
    small, large = sizes
    if small is None or large is None or small < large:
        return
    if tree.at(ball) is None:
        message = f"got {large:.12g}, which is too small (above ball_radius_m, {small:.12g} by default)"
        yield Finding(active, "rule", message)
    else:
        yield Finding(ball, "rule", f"got {small:.12g}, which is too large (below active_radius_m, {large:.12g})")


NARROWEST_SWEEP = 1e-9
"""Relative width of a sweep up to which its ends are taken for one value: rounding leaves nothing in between."""


def _sweep(tree: _Tree) -> Iterator[Finding]:
    parameter = tree.at("sweep.parameter")
    if isinstance(parameter, str) and parameter in SWEEPABLE:
        low, high = (0, 90) if parameter == "inclination_deg" else (SMALLEST, LARGEST)
        for path in ("sweep.from", "sweep.to"):
            value = tree.number(path)
            if value is not None and not low <= value <= high:
                yield Finding(path, "sweep_range", tree.at(path))
    first, last = tree.number("sweep.from"), tree.number("sweep.to")
    if first is not None and last is not None and abs(last - first) <= NARROWEST_SWEEP * max(abs(first), abs(last)):
        yield Finding("sweep.to", "rule", f"got {last:.12g}, the same as sweep.from to nine digits (a different value)")


def _simulation(tree: _Tree) -> Iterator[Finding]:
    alone = tree.at("sweep") is None and "sweep" not in tree.wrong
    if tree.at("simulation.diagram") is True and alone:
        yield Finding("simulation.diagram", "rule", "a bifurcation diagram needs a sweep (add one, or set it to false)")
    parameter = "length_m" if alone else tree.at("sweep.parameter")
    if not isinstance(parameter, str) or parameter not in SWEEPABLE:
        return
    low, high = (0, 90) if parameter == "inclination_deg" else (SMALLEST, LARGEST)
    for path in ("simulation.portraits", "simulation.displacement"):
        values = tree.at(path)
        for i, value in enumerate(values if isinstance(values, list) else ()):
            here = f"{path}.{i}"
            if here not in tree.wrong and type(value) in (int, float) and not low <= value <= high:
                yield Finding(here, "sweep_range", value)


MARGINS = ("margin_period_doubling_percent", "margin_grazing_percent", "margin_any_percent")
AT_DESIGN = (*MARGINS, "u_ave_at_least_v", "u_bottom_top_difference_at_most_v", "deflection_at_most_m")
"""Requirements that are judged at the design point."""

VOLTAGE = (
    "u_ave_at_least_v",
    "u_ave_difference_at_most_v",
    "u_bottom_top_difference_at_most_v",
    "deflection_at_most_m",
)
NEEDS = {
    "sweep": (("stable_from", "stable_to", "u_ave_difference_at_most_v"), "a range of the swept parameter needs"),
    "device.ball_mass_kg": (VOLTAGE, "voltage and deflection need"),
    "simulation": (("crosscheck_passed",), "a cross-check needs"),
}
"""What must be in the scenario for requirements to be judged, with their keys."""

STABLE, ANGLES = ("stable_from", "stable_to"), ("inclination_from_deg", "inclination_to_deg")
"""Requirements that are the two ends of a range."""


def _requirements(tree: _Tree) -> Iterator[Finding]:
    """What is required must be something that this scenario can decide."""
    block = tree.at("requirements")
    if "requirements" in tree.bare or (isinstance(block, dict) and all(value is None for value in block.values())):
        yield Finding("requirements", "rule", "nothing is required in it (give one of its keys, or delete it)")
    if not isinstance(block, dict):
        return
    here = {key: f"requirements.{key}" for key, value in block.items() if value is not None}
    for needed, (keys, what) in NEEDS.items():
        for key in keys:
            if key in here and tree.absent(needed):
                yield Finding(here[key], "rule", f"{what} {needed}, which is not given (give it, or leave this out)")
    if block.get("crosscheck_passed") is False:
        yield Finding(here["crosscheck_passed"], "rule", "got false, which requires nothing (true, or leave it out)")
    yield from _at_design(tree, here)
    for first, last in (STABLE, ANGLES):
        if (first in here) != (last in here):
            given, missing = (first, last) if first in here else (last, first)
            yield Finding(here[given], "rule", f"{missing} is not given (both ends of a range, or neither)")
        elif first in here and tree.at(here[first]) == tree.at(here[last]):
            yield Finding(here[last], "rule", f"got the same value as {first}, which makes no range (a different one)")
    ends = [end for end in (tree.number("sweep.from"), tree.number("sweep.to")) if end is not None]
    for path in (here[key] for key in STABLE if key in here and len(ends) == 2):
        value = tree.number(path)
        if value is not None and not min(ends) <= value <= max(ends):
            allowed = f"a number from {min(ends):.12g} to {max(ends):.12g}"
            yield Finding(path, "rule", f"got {value:.12g}, which is outside the sweep ({allowed})")


def _at_design(tree: _Tree, here: dict[str, str]) -> Iterator[Finding]:
    """Where a parameter is swept, its design value is given if something is required of the design point."""
    swept = tree.at("sweep.parameter")
    if not isinstance(swept, str) or swept not in SWEEPABLE:
        return
    given = SWEEPABLE[swept]
    judged = AT_DESIGN if swept == "inclination_deg" else (*AT_DESIGN, *ANGLES)
    for path in (here[key] for key in judged if key in here and tree.absent(given)):
        message = f"the design point that it is judged at is not given (give {given}, or leave this out)"
        yield Finding(path, "rule", message)
    for path in (here[key] for key in MARGINS if key in here and tree.number("inclination_deg") == 0):
        if swept == "inclination_deg":
            message = f"there is no percentage of an inclination of 0 (require {' and '.join(ANGLES)} instead)"
            yield Finding(path, "rule", message)


STIFFEST = 1e12
"""Largest factor on a membrane's stiffness."""


def _accuracy(tree: _Tree) -> Iterator[Finding]:
    factors = tree.at("accuracy.ladder")
    if not isinstance(factors, list):
        return
    before = 0.0
    for i, factor in enumerate(factors):
        here = f"accuracy.ladder.{i}"
        if here in tree.wrong or type(factor) not in (int, float):
            return
        if not 1 <= factor <= STIFFEST or factor <= before:
            allowed = f"numbers from 1 to {STIFFEST:g}, each above the one before"
            yield Finding(here, "rule", f"got {factor:.12g}, which is out of range or order ({allowed})")
            return
        before = float(factor)


def _title(tree: _Tree) -> Iterator[Finding]:
    title = tree.at("title")
    if isinstance(title, str) and not (title.isprintable() and title.strip()):
        yield Finding("title", "rule", f"got {title[:60]!r} (printable text on one line)")
