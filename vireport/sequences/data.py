"""The families of motions as plain data, for results.json."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np

from vireport.physics import Membrane
from vireport.sequences.energy import generation
from vireport.sequences.families import Atlas, Claim, Family, Mark, Vertex
from vireport.sequences.polish import PolishedPoint


def motions_data(atlas: Atlas) -> dict[str, Any]:
    """The limits of the motions, and how completely their families are found."""
    completeness = [
        {"word": of.word, "claim": of.claim, "resolution": of.resolution, "undecided": of.undecided}
        for of in atlas.completeness
    ]
    rest = {"word": None, "claim": Claim.FOLLOWED, "resolution": None, "undecided": None}
    return {
        "impacts": atlas.limits.impacts, "periods": atlas.limits.periods, "completeness": [*completeness, rest],
    }  # fmt: skip


def families_data(atlas: Atlas, membrane: Membrane | None) -> list[dict[str, Any]]:
    """Every family, with what happens on it and, where there is a membrane, what its impacts generate."""
    return [_family(family, membrane) for family in atlas.families]


def _family(family: Family, membrane: Membrane | None) -> dict[str, Any]:
    value = family.sweep_value
    return {
        "number": family.number,
        "word": family.sequence.word,
        "ratio": family.sequence.ratio,
        "periods": family.sequence.periods,
        "from": float(value.min()),
        "to": float(value.max()),
        "begins_with": _end(family, family.ends[0]),
        "ends_with": _end(family, family.ends[1]),
        "stable_range": [dict(zip(("from", "to"), pair, strict=True)) for pair in family.stable_ranges],
        "critical_points": [_point(mark, mark.point) for mark in family.marks if mark.point is not None],
        "generation": [] if membrane is None else _generation(family, membrane),
        "sweep_value": value.tolist(),
        "d": family.d.tolist(),
        "velocity": family.velocity.tolist(),
        "phase_rad": family.phase.tolist(),
        "trace": [float(x) if isfinite(x) else None for x in family.trace],
        "determinant": family.determinant,
        "stable": family.stable.tolist(),
    }


def _end(family: Family, mark: Mark) -> dict[str, Any]:
    vertex, value = mark.vertex, float(family.sweep_value[mark.row])
    label = None if vertex is None else vertex.label
    return {"kind": mark.event, "label": label, "families": _families(vertex), "sweep_value": value}


def _families(vertex: Vertex | None) -> list[int]:
    return [] if vertex is None else list(vertex.families)


def _point(mark: Mark, point: PolishedPoint) -> dict[str, Any]:
    return {
        "label": None if mark.vertex is None else mark.vertex.label,
        "kind": mark.event,
        "sweep_value": point.sweep_value,
        "error_bound": point.error_bound if isfinite(point.error_bound) else None,
        "d": point.d,
        "gbar": point.gbar,
        "word": point.motion.sequence.word,
        "velocity": point.motion.velocity.tolist(),
        "phase_rad": point.motion.phase.tolist(),
        "families": _families(mark.vertex),
    }


def _generation(family: Family, membrane: Membrane) -> list[dict[str, Any]]:
    """At both ends and in the middle."""
    whole = generation(family, membrane)
    rows = dict.fromkeys(int(row) for row in np.linspace(0, len(family.x) - 1, 3))
    return [
        {
            "sweep_value": float(family.sweep_value[row]),
            "u_impacts_v": whole.impacts_v[row].tolist(),
            "u_ave_v": float(whole.average_v[row]),
            "impacts_per_s": float(whole.impacts_per_s[row]),
            "u_per_second_v": float(whole.per_second_v[row]),
        }
        for row in rows
    ]
