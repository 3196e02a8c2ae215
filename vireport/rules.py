"""What must hold between several keys of a scenario, checked on the tree as it was read.

Not part of the validation of single values: it would come to such rules only once every value is right, and
then a reader would be told of his mistakes in two instalments.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from vireport.blocks import LARGEST, SMALLEST, SWEEPABLE, Membrane


class Finding(NamedTuple):
    """Something wrong at a path. `kind` is pydantic's word for it, or one of ours.

    Ours are "sweep_range", where the value is out of the range of the parameter that is swept, and "rule",
    where `value` is the message itself.
    """

    path: str
    kind: str
    value: object = None


def check(data: dict[str, Any], wrong: Collection[str]) -> list[Finding]:
    """Find what does not fit together.

    Parameters
    ----------
    data : dict
        The tree.
    wrong : collection of str
        Paths that are wrong in themselves: they are not compared with anything.
    """
    tree = _Tree(data, wrong)
    return [*_required(tree), *_masses(tree), *_radii(tree), *_sweep(tree), *_simulation(tree), *_title(tree)]


class _Tree:
    def __init__(self, data: dict[str, Any], wrong: Collection[str]) -> None:
        self.data, self.wrong = data, wrong

    def at(self, path: str) -> Any:
        node: Any = self.data
        for step in path.split("."):
            node = node.get(step) if isinstance(node, dict) else None
        return node

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


def _title(tree: _Tree) -> Iterator[Finding]:
    title = tree.at("title")
    if isinstance(title, str) and not (title.isprintable() and title.strip()):
        yield Finding("title", "rule", f"got {title[:60]!r} (printable text on one line)")
