"""What measured impacts say of a device, as JSON, as text, and as a scenario of the device that was measured."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from typing import Any

import numpy as np
import yaml
from scipy.special import stdtrit  # type: ignore[import-untyped]

from vireport.base import NumericalError, Progress
from vireport.cli.outcome import CommandOutcome
from vireport.measurement import Fitted, Identification, Unidentifiable, Unknown, answered, inquiry_of, read_record
from vireport.scenario import DesignInput, Distribution, Loaded, Scenario, loads, to_dict
from vireport.study import json_bytes, provenance_of
from vireport.text import Table, bounded, numbers, plain_text, significant, texts
from vireport.wording import Words

NAMES = "identified.json", "identified.yaml"
"""Files that the command may write."""

CONFIDENCE = 0.95
SAME_RESTITUTION = 1e-9
"""Difference of two restitutions that a scenario has as one: beyond what times tell, and before its own limit."""

SWAPPED = "swapped_membranes"
"""What is wrong where it is no key of a scenario."""

DISTORTION = "harmonics"
"""What a record may not show of `excitation`."""

WORDS = Words("identify")


def outcome(
    loaded: Loaded,
    path: str,
    referenced: bool,
    free: list[str],
    command: str,
    json: bool,
    say: Progress,
) -> CommandOutcome:
    """Identify a device from a record of its impacts.

    Raises
    ------
    UsageError, ScenarioError
        If the question or the record is malformed.
    NumericalError
        If the record does not hold what is asked for.
    """
    inquiry = inquiry_of(loaded.scenario, free, referenced)
    say("reading the record")
    record = read_record(path, float(inquiry.model.device.frequency_hz))
    try:
        answer = answered(inquiry, record, referenced, say)
    except Unidentifiable as refused:
        raise NumericalError(WORDS("refused", refused.left_open, not referenced)) from refused
    scenario = _scenario_text(loaded.scenario, answer)
    data = json_bytes(_data(answer, scenario), provenance_of(loaded, command))
    files = {"identified.json": data}
    if scenario is not None:
        files["identified.yaml"] = scenario.encode()
    failure = "" if answer.misfit.accepted else f"the data contradict the model: {WORDS('reason', answer.misfit)}"
    printed: str | bytes = data if json else plain_text(_parts(answer, record.unused)) + "\n"
    return CommandOutcome(printed, files, failure=failure, exit_code=bool(failure), stale=NAMES)


def _rows(answer: Identification) -> Iterator[tuple[Unknown, float, float, float]]:
    """What is identified: value, standard error and half of the interval; nothing where the model does not fit."""
    if not answer.misfit.accepted or not isinstance(answer.found, Fitted):
        return
    own = answer.found.adjusted
    wide = float(stdtrit(own.freedom, (1 + CONFIDENCE) / 2))
    for x in answer.inquiry.unknowns:
        value, error = own.model.value_of(x), own.deviation_of(x)
        yield x, value % (2 * np.pi) if x is Unknown.PHASE else value, error, wide * error


def _data(answer: Identification, scenario: str | None) -> dict[str, Any]:
    found, misfit = answer.found, answer.misfit
    rows = list(_rows(answer))
    fitted = found if isinstance(found, Fitted) else None
    count = len(rows)
    instead = misfit.explanation
    return {
        "identified": [
            {"name": x, "unit": x.unit or "1", "value": v, "standard_error": e, "from": v - half, "to": v + half}
            for x, v, e, half in rows
        ],
        "covariance": fitted.adjusted.covariance[:count, :count].tolist() if fitted and rows else [],
        "phase_at_s": answer.origin_s if Unknown.PHASE in answer.inquiry.unknowns else None,
        "timing_error_s": fitted.adjusted.timing_error_s if fitted else None,
        "missed": [x.missed_s + answer.origin_s for x in fitted.gaps if x.missed_s is not None] if fitted else [],
        "false": [time + answer.origin_s for time in fitted.false] if fitted else [],
        "left_out": [
            {"from": gap.start_s + answer.origin_s, "to": gap.end_s + answer.origin_s}
            for gap in fitted.gaps
            if gap.missed_s is None
        ]
        if fitted
        else [],
        "misfit": {
            "statistic": misfit.statistic,
            "p_value": misfit.p_value,
            "accepted": misfit.accepted,
            "reason": WORDS("reason", misfit),
            "alternative": None if instead is None else SWAPPED if instead.swapped else instead.unknown,
            "alternative_value": instead.value if instead is not None and instead.unknown else None,
            "alternative_standard_error": instead.standard_error if instead is not None and instead.unknown else None,
            "untested": [
                *misfit.untested,
                *([SWAPPED] if misfit.swapped_untested else []),
                *([DISTORTION] if misfit.distortion_untested else []),
            ],
        },
        "scenario": scenario,
    }


def _scenario_text(scenario: Scenario, answer: Identification) -> str | None:
    """The scenario with what was identified, its intervals as tolerances; None where that is no valid one."""
    values = {DesignInput(x.value): (v, e, half) for x, v, e, half in _rows(answer) if x.design_input is not None}
    if not values or any(not x.limits[0] <= v <= x.limits[1] for x, (v, _, _) in values.items()):
        return None
    data = to_dict(scenario)
    tolerances = data["tolerances"] or {}
    device, found = data["device"], answer.found
    assert isinstance(found, Fitted)
    restitutions = (DesignInput.RESTITUTION, DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP)
    if any(x in restitutions for x in values):
        # Of one membrane alone the other stays; of both together their difference does.
        bottom, top = (float(found.adjusted.model.device.value_of(x)) for x in restitutions[1:])
        same = abs(bottom - top) < SAME_RESTITUTION
        device.update(
            restitution=(bottom + top) / 2 if same and restitutions[0] in values else None,
            restitution_bottom=None if same and restitutions[0] in values else bottom,
            restitution_top=None if same and restitutions[0] in values else bottom if same else top,
        )
        # A tolerance of what the file no longer gives has no meaning.
        for x in restitutions:
            tolerances.pop(x.value, None)
            tolerances.pop(f"{x.value}_percent", None)
    normal = tolerances.get("distribution") == Distribution.NORMAL.value
    for x, (value, error, half) in values.items():
        *blocks, key = x.path.split(".")
        if x not in restitutions:
            reduce(dict.__getitem__, blocks, data)[key] = value
        tolerances.pop(f"{x.value.rpartition('_')[0] if x.unit else x.value}_percent", None)
        # Of a normal distribution a tolerance is three standard deviations.
        tolerances[x.value] = 3 * error if normal else half
    data["tolerances"] = tolerances
    text = str(yaml.safe_dump(_present(data), sort_keys=False, allow_unicode=True))
    loads(text, "identified.yaml")
    return text


def _present(data: dict[str, Any]) -> dict[str, Any]:
    """Plain data without what is absent."""
    kept = {key: value for key, value in data.items() if value is not None}
    return {key: _present(value) if isinstance(value, dict) else value for key, value in kept.items()}


def _parts(answer: Identification, unused: tuple[str, ...]) -> Iterator[str | Table]:
    found, misfit = answer.found, answer.misfit
    if isinstance(found, Fitted):
        missed = sum(gap.missed_s is not None for gap in found.gaps)
        told = WORDS("summary", len(found.times), found.adjusted.timing_error_s, missed, len(found.false), found.lost)
        if misfit.accepted:
            p = "" if misfit.p_value is None else f" (p = {significant(misfit.p_value, 2)})"
            yield f"{told} {WORDS('reason', misfit).capitalize()}{p}."
        else:
            yield told
    if not misfit.accepted:
        yield f"The data contradict the model: {WORDS('reason', misfit)}."
    rows = tuple(
        (
            WORDS("name_of", x),
            bounded(v, e / 100),  # to two digits of its standard error, as the ends of the interval
            significant(e, 2),
            *(bounded(end, e / 100) for end in (v - half, v + half)),
            x.unit,
        )
        for x, v, e, half in _rows(answer)
    )
    if rows:
        columns = (*texts("Input"), *numbers("Value", "Standard error", "From", "To"), *texts("Unit"))
        yield Table("Identified, with 95 % intervals", columns, rows)
    unseen = misfit.untested, misfit.swapped_untested, misfit.distortion_untested
    if misfit.accepted and (untested := WORDS("untested", *unseen)):
        yield untested
    if unused:
        yield WORDS("not_used", unused)
