"""What figures show, read back: curves by the words of their legend, and captions, from results.json and definitions.

A legend says which look stands for what. So a curve is found by its words, and held against what these words mean:
curves with the looks of one another, a wrong scale and a wrong unit all fail.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
from definitions import VACUUM_PERMITTIVITY, mean
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from shown import PREFIXES, Amount, Below, Said, plain
from shown_tables import (
    WORDS_OF,
    Results,
    digits_of,
    in_input,
    inequality,
    number,
    percentage,
    rungs,
    speeds_along,
    swept,
)

Points = list[tuple[float, float]]

CLOSE = 1e-9
"""Relative difference between a number that is computed here and one that is drawn."""


def legend_of(figure: Figure) -> dict[str, Any]:
    """The lines of a figure's legends, by their words."""
    return {plain(line.get_label()): line for line in figure.artists}


def curve(axes: Axes, look: Any, style: Any) -> np.ndarray:
    """The points of the curves with the colour and width of one look, and the dashes of another, (k, 2).

    Unstable motions are drawn half as wide.
    """
    width = look.get_linewidth() * (1.0 if style.get_linestyle() == "-" else 0.5)
    lines = [line for line in axes.findobj(Line2D) if line.get_marker() in ("None", None) and len(line.get_xdata()) > 2]
    of = [line for line in lines if line.get_color() == look.get_color() and line.get_linewidth() == width]
    of = [line for line in of if line.get_linestyle() == style.get_linestyle()]
    points = [np.column_stack([np.asarray(values, dtype=float) for values in line.get_data()]) for line in of]
    return np.concatenate(points) if points else np.empty((0, 2))


def marked(axes: Axes, look: Any) -> np.ndarray:
    """The points of the markers with a look, (k, 2)."""
    lines = [line for line in axes.findobj(Line2D) if line.get_marker() == look.get_marker()]
    lines = [line for line in lines if line.get_color() == look.get_color()]
    return np.concatenate([np.column_stack(line.get_data()) for line in lines])


def curve_faults(words: str, drawn: np.ndarray, known: Points, period: float | None = None) -> Iterator[str]:
    """Points of results.json that are not on the curve with some words."""
    for x, y in known:
        apart = drawn - (x, y)
        if period is not None:
            apart[:, 1] = (apart[:, 1] + period / 2) % period - period / 2
        size = np.abs(apart) / (1e-300 + np.maximum(1e-3, np.abs((x, y))))
        if not len(drawn) or np.nanmin(size.max(axis=1)) > CLOSE:
            yield f"{words}: ({x:.6g}, {y:.6g}) is not on its curve"
            return


def admissible(branch: dict[str, Any]) -> list[int]:
    """Rows of the motions of a branch in which the ball stays between the membranes."""
    return [k for k, there in enumerate(branch["admissible"]) if there]


def motions(x: Results, stable: bool) -> Iterator[tuple[dict[str, Any], int]]:
    """The admissible motions along the sweep, as branches and rows."""
    for branch in x.data["branches"]:
        for k, word in enumerate(branch["stability"]):
            if branch["admissible"][k] and word.startswith("stable") is stable and branch["critical_point"][k] is None:
                yield branch, k


def speeds(x: Results, branch: dict[str, Any], k: int) -> tuple[float, float]:
    return x.speeds((branch["velocity_bottom"][k], branch["velocity_top"][k]), branch["sweep_value"][k])


def voltage_faults(x: Results, figure: Figure) -> Iterator[str]:
    """Figure 7: the voltages of each motion, in the unit of the axis."""
    (axes, *_), looks = figure.axes, legend_of(figure)
    prefix = re.search(r"\[(.?)V\]", axes.get_ylabel())[1]
    for stability in ("stable", "unstable"):
        known: dict[str, Points] = {"Uₐᵥₑ": [], "bottom": [], "top": []}
        for branch, k in motions(x, stability == "stable"):
            bottom, top = (x.device.gain(speed) for speed in speeds(x, branch, k))
            for points, volts in zip(known.values(), (mean([bottom, top]), bottom, top), strict=True):
                points.append((branch["d"][k], volts / 10.0 ** PREFIXES[prefix]))
        for words, points in known.items():
            if points:
                yield from curve_faults(f"{words}, {stability}", curve(axes, looks[words], looks[stability]), points)


def motion_faults(x: Results, figure: Figure) -> Iterator[str]:
    """Figure 2: speed, phase and flight time of both impacts."""
    looks, ratio = legend_of(figure), x.device.period_ratio
    sides = {"bottom": ("bottom", lambda q: q), "top": ("top", lambda q: 1 - q)}
    for stability in ("stable", "unstable"):
        rows = list(motions(x, stability == "stable"))
        for words, (side, share) in sides.items() if rows else ():
            columns = (
                [abs(branch[f"velocity_{side}"][k]) for branch, k in rows],
                [branch[f"phi_{side}_rad"][k] for branch, k in rows],
                [ratio * share(branch["q"][k]) for branch, k in rows],
            )
            for axes, values, period in zip(figure.axes[:3], columns, (None, 2 * pi, None), strict=True):
                drawn = curve(axes, looks[words], looks[stability])
                points = [(branch["d"][k], y) for (branch, k), y in zip(rows, values, strict=True)]
                yield from curve_faults(f"{axes.get_ylabel()}, {words}, {stability}", drawn, points, period)


def stability_faults(x: Results, figure: Figure) -> Iterator[str]:
    """Figure 4: the discriminant and the eigenvalues where they are shown, and the borders of stability."""
    looks, determinant = legend_of(figure), x.device.determinant
    wide = looks.get("Re λ")
    for stability in ("stable", "unstable"):
        discriminants, eigenvalues = [], []
        for branch, k in motions(x, stability == "stable"):
            trace, d = branch["trace"][k], branch["d"][k]
            root = trace**2 - 4 * determinant
            discriminants.append((d, root))
            larger = trace / 2 if root < 0 else (trace + (sqrt(root) if trace > 0 else -sqrt(root))) / 2
            parts = [larger] if root < 0 else [larger, determinant / larger]
            eigenvalues += [(d, part) for part in parts if abs(part) < 1]
        if not discriminants:
            continue
        for axes, known in zip(figure.axes[:2], (discriminants, eigenvalues), strict=True):
            lines = [line for line in axes.findobj(Line2D) if len(line.get_xdata()) > 2]
            of = [line for line in lines if line.get_linestyle() == looks[stability].get_linestyle()]
            drawn = [np.column_stack(line.get_data()) for line in of]
            if wide is not None:
                drawn += [
                    np.column_stack(line.get_data()) for line in lines if line.get_linewidth() == wide.get_linewidth()
                ]
            yield from curve_faults(f"{axes.get_ylabel()}, {stability}", np.concatenate(drawn), known)
    border = looks["Δ = 0, λ = ±1"]
    for axes, expected in zip(figure.axes[:2], ({0.0}, {-1.0, 1.0}), strict=True):
        drawn = {
            float(line.get_ydata()[0])
            for line in axes.findobj(Line2D)
            if line.get_linestyle() == border.get_linestyle() and list(line.get_xdata()) == [0, 1]
            and line.get_linewidth() == border.get_linewidth()
        }  # fmt: skip
        if drawn != expected:
            yield f"{axes.get_ylabel()}: the borders of stability are drawn at {drawn}"


def answer_faults(x: Results, figure: Figure) -> Iterator[str]:
    """The first page's figure: impact speeds, where they are stable, its ends, the design point and its room."""
    (axes,) = figure.axes
    texts = {plain(text.get_text()): text for text in axes.texts}
    for stability in ("stable", "unstable"):
        rows = list(motions(x, stability == "stable"))
        for side, name in enumerate(("bottom", "top")):
            look = next((text.get_color() for text_of, text in texts.items() if text_of == name), None)
            lines = [line for line in axes.lines if line.get_color() == look and len(line.get_xdata()) > 2]
            lines = [line for line in lines if (line.get_linestyle() == "-") is (stability == "stable")]
            known = [(branch["sweep_value"][k], speeds(x, branch, k)[side]) for branch, k in rows]
            if look is not None and known:
                drawn = np.concatenate([np.column_stack(line.get_data()) for line in lines])
                yield from curve_faults(f"impact speed, {name}, {stability}", drawn, known)
    shaded = sorted(patch.get_extents().transformed(axes.transData.inverted()).intervalx for patch in axes.patches)
    expected = sorted((part["from"], part["to"]) for part in x.data["stable_range"])
    if not np.allclose(shaded, expected, rtol=1e-6):
        yield f"{shaded} are shaded, and not {expected}"
    rooms = [text for text in texts if "of room" in text]
    if len(rooms) != sum("of room" in said.words for said in _on_the_answer(x)):
        yield f"the room of the design point is shown as {rooms}"
    for said in _on_the_answer(x):
        if not any(not said.faults(text, whole=True) for text in texts):
            yield f"{said.words} is not among {list(texts)}"


def _ends(x: Results) -> list[tuple[str, float]]:
    """Where stable motion ends in the sweep: the labels of the critical points, and the values."""
    labels = {point["label"] for point in x.points}
    ends = [(part[f"{end}_reason"], part[end]) for part in x.data["stable_range"] for end in ("from", "to")]
    return [(label, value) for label, value in ends if label in labels]


def _on_the_answer(x: Results) -> Iterator[Said]:
    """The texts of that figure, beside the names of both membranes."""
    low, high = sorted((x.sweep["from"], x.sweep["to"]))
    for label, value in _ends(x):
        yield Said(f"{label} {{}}", swept(x, value, digits_of(x, x.parameter, value, 3)))
    at = getattr(x.device, x.parameter)
    if at is None or not low <= at <= high:
        return
    yield Said("design {}", swept(x, at))
    around = [part for part in x.data["stable_range"] if part["from"] < at < part["to"]]
    ends = [value for part in around for _, value in _ends(x) if value in (part["from"], part["to"])]
    if ends:
        nearest = min(ends, key=lambda value: abs(value - at))
        if abs(nearest - at) > 0.12 * (high - low):
            yield Said("{} of room", percentage(abs(nearest / at - 1)))


def path_faults(x: Results, figure: Figure) -> Iterator[str]:
    """The ball's distance from the bottom membrane over a period, by its equation of motion."""
    axes, looks, design = figure.axes[-1], legend_of(figure), x.design
    k, ratio = x.stable[0], x.device.period_ratio
    d, gbar = design["d"][k], x.device.gbar
    unit = x.device.length_m / d
    ball = np.concatenate(
        [np.column_stack(line.get_data()) for line in axes.lines if line.get_color() == looks["ball"].get_color()]
    )
    meets = {"impact, bottom": [(0.0, 0.0), (ratio, 0.0)], "impact, top": [(ratio * design["q"][k], x.device.length_m)]}
    for words, points in meets.items():
        yield from curve_faults(words, marked(axes, looks[words]), points)
        yield from curve_faults("ball", ball, points)
    phase, velocity = design["phi_bottom_rad"][k], -x.device.restitution_bottom * design["velocity_bottom"][k]
    for time, distance in ball[(ball[:, 0] > 0) & (ball[:, 0] < ratio * design["q"][k])]:
        t = 2 * time  # in units of t_c, half a forcing period
        z = d / 2 + t * (velocity + gbar * t / 2 - sin(phase) / pi) + (cos(phase) - cos(pi * t + phase)) / pi**2
        if abs(unit * (d / 2 - z) - distance) > 1e-9 * x.device.length_m:
            yield f"ball: at {time:.6g} periods {distance:.6g} m are drawn, and not {unit * (d / 2 - z):.6g} m"
            return


def cycles(x: Results) -> list[tuple[float, float, float]]:
    """Of the stable motion that gains most: charge, voltage and energy of the impact at the bottom and at the top."""
    of, area = x.device.membrane, pi * x.device.membrane["active_radius_m"] ** 2
    capacitance = VACUUM_PERMITTIVITY * of["relative_permittivity"] * area / of["thickness_m"]
    pair = max(x.design_speeds, key=lambda pair: sum(map(x.device.energy, pair)))
    volts = [x.device.gain(speed) + of["bias_voltage_v"] for speed in pair]
    return [(capacitance * high, high, x.device.energy(v)) for high, v in zip(volts, pair, strict=True)]


def cycle_faults(x: Results, figure: Figure) -> Iterator[str]:
    """The electrical cycle: stretched at the bias, at constant charge, and back along the flat capacitance."""
    looks, bias = legend_of(figure), x.device.membrane["bias_voltage_v"]
    units = [
        10.0 ** PREFIXES[re.search(rf"\[(.?){unit}\]", label)[1]]
        for label, unit in ((figure.axes[0].get_xlabel(), "C"), (figure.axes[0].get_ylabel(), "V"))
    ]
    for axes, (charge, high, energy), where in zip(figure.axes, cycles(x), ("bottom", "top"), strict=True):
        drawn = {line.get_color(): np.column_stack(line.get_data()) * units for line in axes.lines}
        stages = {
            "charged to the bias, stretched": [(0.0, 0.0), (charge, bias)],
            "isolated, until it is flat": [(charge, bias), (charge, high)],
            "discharged, flat": [(charge, high), (0.0, 0.0)],
        }
        for words, points in stages.items():
            if not np.allclose(drawn[looks[words].get_color()], points, rtol=CLOSE, atol=0):
                yield f"{where}, {words}: {points} are not drawn"
        title = axes.get_title(loc="left")
        yield from filter(None, [Said(f"impact on the {where}: area {{}}", Amount(energy, "J", 3)).faults(title)])


def captions(x: Results) -> Iterator[tuple[str, Said]]:
    """What captions and alternative texts of simulated figures and of those of families say, by the figure."""
    if x.sweep:
        traces = [branch["trace"][k] for branch in x.data["branches"] for k in admissible(branch)]
        roots = [(abs(trace), trace**2 - 4 * x.device.determinant) for trace in traces]
        largest = max((size + sqrt(max(root, 0.0))) / 2 for size, root in roots)
        told = Said("|λ| reaches {}", number(largest, 3)) if largest < 1e4 else Said("|λ| exceeds 10000")
        yield "figure-4", told if largest > 1.6 else Said("where Δ < 0.")
        along = speeds_along(x) or [speeds(x, branch, k) for branch, k in motions(x, False)]
        for side, name in enumerate(("bottom", "top")):
            found = [pair[side] for pair in along]
            yield "figure-answer", Said(f"at the {name} {{}} to {{}} m/s", number(min(found), 3), number(max(found), 3))
        ranges = [inequality(x, part, x.parameter) for part in x.data["stable_range"]]
        amounts = [amount for part in ranges for amount in part.amounts]
        yield "figure-answer", Said(f"Stable: {'; '.join(part.words for part in ranges) or 'nowhere'}.", *amounts)
        kinds = {point["label"]: WORDS_OF[point["kind"]] for point in x.points}
        for label, value in _ends(x):
            place = swept(x, value, digits_of(x, x.parameter, value, 3))
            yield "figure-answer", Said(f"{kinds[label].capitalize()} {label} at {{}}.", place)
    if x.stable and x.device.membrane["thickness_m"] is not None:
        bias, of = Amount(x.device.membrane["bias_voltage_v"], "V"), x.device.membrane
        breaking = Amount(of["breakdown_field_v_m"] * of["thickness_m"], "V", 3)
        yield "figure-cycle", Said("up to the bias of {}, isolated", bias)
        yield "figure-cycle", Said("the membrane breaks down at {}.", breaking)
        for where, (charge, high, energy) in zip(("bottom", "top"), cycles(x), strict=True):
            amounts = Amount(charge, "C", 3), bias, Amount(high, "V", 3), Amount(energy, "J", 3)
            yield "figure-cycle", Said(f"on the {where}: {{}} isolated from {{}} to {{}}, area {{}}", *amounts)
    if x.stable:
        share = number(x.design["q"][x.stable[0]], 3)
        yield "figure-device", Said("over one period: it meets the top after {} of it.", share)
    if x.data["families"]:
        best = rungs(x)[0]
        rate = Amount(best["Per second"].value, "V/s", 3)
        yield "figure-ladder", Said(f"{best['Word']} generates most, up to {{}}.", rate)
        yield "figure-atlas", Said(f"{len(x.data['families'])} families that meet at ")
    of = x.data["simulation"]
    if of is None:
        return
    if (follow := of["follow"]) is not None:
        count = sum(len(follow[way]["jumps"]) for way in ("up", "down"))
        ends = [(loop["from"], loop["to"]) for loop in follow["loops"]]
        parts = "; ".join([f"{x.symbol} = {{}} to {{}}"] * len(ends))
        amounts = [amount for low, high in ends for amount in (number(low, 3), swept(x, high, 3))]
        yield "figure-hysteresis", Said(f"{count} jumps; the motion depends on the direction at {parts}.", *amounts)
    if x.scenario["simulation"]["diagram"]:
        words: dict[str, list[float]] = {}
        for sample in of["samples"]:
            for word in dict.fromkeys(end["word"] for end in sample["ends"] if end["outcome"] == "periodic"):
                words.setdefault(word, []).append(sample["sweep_value"])
        for word, values in words.items():
            ends = sorted({min(values), max(values)})
            amounts = [number(ends[0], 3)] * (len(ends) - 1) + [swept(x, ends[-1], 3)]
            yield (
                "figure-diagram",
                Said(f"{word} at {len(values)} ({x.symbol} = {' to '.join(['{}'] * len(ends))})", *amounts),
            )
    yield from _portraits(x)


def _portraits(x: Results) -> Iterator[tuple[str, Said]]:
    """Portraits at the design point, of its stable motion: the one that is simulated."""
    asked, k = x.scenario["simulation"], x.stable[0] if x.stable else None
    for figure, key in (("figure-3", "portraits"), ("figure-6", "displacement")):
        if k is None or asked[key] != [getattr(x.device, x.parameter)]:
            continue
        of, trace = x.design, x.design["trace"][k]
        root = sqrt(trace**2 - 4 * x.device.determinant)
        at = in_input(x.parameter, getattr(x.device, x.parameter))
        speeds_of = number(of["velocity_bottom"][k], 3), number(-of["velocity_top"][k], 3)
        said = f"{x.symbol} = {{}}, d = {{}}, ḡ = {{}}: BT, every forcing period, |Ż| = {{}}, {{}}, φ = {{}} rad, "
        phase, growth = number(of["phi_bottom_rad"][k], 3), number((abs(trace) + root) / 2, 3)
        groups = number(x.device.d, 3), number(x.device.gbar, 3)
        said += "residual {}, largest |λ| = {}"
        yield figure, Said(said, at, *groups, *speeds_of, phase, Below(1e-9), growth)
        if figure == "figure-3":
            yield figure, Said("over time (right), in units of F/(2 M f) and F/(4 M f²), ")
        else:
            yield figure, Said("the ball x in units of F/(4 M f²), ")
