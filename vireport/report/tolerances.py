"""The section on tolerances: whether every device works, how many do, and what their motions come to."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.report.pages import Block, Paragraph
from vireport.study import Study
from vireport.text import Table, capital, numbers, percent, significant, texts

ANSWERS = {
    "proved": "Every device within the tolerances has a stable 1:1 motion. This is proved: {boxes} cover them all; in "
    "each, motions, multipliers, impact velocities and the distance to the membranes at every time of the flights are "
    "enclosed in affine arithmetic.",
    "refuted": "Not every device within the tolerances has a stable 1:1 motion. Towards the worst one found, stable "
    "motion ends at {share} of the way from the design; results.json has it as a scenario.",
    "undecided": "Whether every device within the tolerances has a stable 1:1 motion is not decided: for {open} of "
    "their volume in (*d*, *ḡ*, *r*) it is neither proved nor refuted.",
}

QUANTITIES = {"velocity_bottom_m_s": "*Ż*_B [m/s]", "velocity_top_m_s": "*Ż*_T [m/s]", "u_ave_v": "*U*_ave [V]"}


def tolerances(study: Study) -> Iterator[Block]:
    """The answer, the yield, the tolerances with the worst device, and the ranges."""
    found = study.tolerances
    if found is None:
        return
    sampled, worst = found.sampled, found.worst
    boxes, left = (0, None) if found.proof is None else (found.proof.boxes, found.proof.open_share)
    yield Paragraph(
        ANSWERS[found.answer.value].format(
            boxes=f"{boxes} box{'es' * (boxes != 1)}",
            share=percent(worst.share if worst is not None else None),
            open=percent(left),
        )
    )
    interval = f"{percent(sampled.low)} to {percent(sampled.high)}"
    yield Paragraph(
        f"Of {sampled.samples} random devices, {sampled.distribution} within the tolerances, {sampled.stable} have one:"
        f" {percent(sampled.stable / sampled.samples)}, with a 95 % interval of {interval}."
    )
    yield Table(
        "Tolerances",
        (*texts("Input"), *numbers("From", "To", *(["Worst device"] if worst is not None else []))),
        tuple(
            (
                f"{capital(varied.quantity)} *{varied.symbol}* [{varied.unit}]".removesuffix(" []"),
                *(significant(value, 8) for value in ends),
                *([significant(worst.values[varied], 8)] if worst is not None else []),
            )
            for varied, ends in found.region.ranges.items()
        ),
    )
    if found.ranges:
        yield Table(
            "Stable motions of the random devices",
            (*texts("Quantity"), *numbers("Least", "5 %", "Median", "95 %", "Largest")),
            tuple(
                (QUANTITIES[name], *(significant(value, 6) for value in values.values()))
                for name, values in found.ranges.items()
            ),
            "Where a device has several stable motions, each counts.",
        )
