"""What measured impacts say of a device: JSON, text, a report, and a scenario of the device that was measured."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from vireport.base.errors import NumericalError, UsageError
from vireport.base.progress import Progress, WorkStep, portion
from vireport.base.records import keyed
from vireport.base.shares import NORMAL_95
from vireport.cli.outcome import CommandOutcome
from vireport.cli.outputs import file_names
from vireport.design.measured import held_harmonics, share_that_fits
from vireport.identify.opening import IdentifiedRecord, identified_opening, most_hidden, open_opening
from vireport.identify.results import identified_data
from vireport.measurement.flights import Unknown
from vireport.measurement.identification import Fitted, Unidentifiable
from vireport.measurement.inquiry import Identification, answered, inquiry_of
from vireport.measurement.records import read_record, record_contents
from vireport.measurement.shaker import ShakerMotion
from vireport.measurement.signals import OF_SHAKER, Signals, read_signals, with_shaker
from vireport.physics.device import RESTITUTIONS
from vireport.scenario.blocks import Distribution, LayoutBlock, Scenario, keys_left_out, percent_key, to_dict
from vireport.scenario.loading import Loaded, loads
from vireport.scenario.parameters import DesignInput
from vireport.scenario.writing import as_yaml
from vireport.study.judging.alerts import Alert, record_alerts
from vireport.study.judging.opening import Opening
from vireport.study.plan import Task, page_and_figure_files
from vireport.study.provenance import provenance_of, with_pages
from vireport.study.results import json_bytes
from vireport.text.formatting import ROUGHLY, measured, rounded_text
from vireport.text.tables import Table, plain_text, worded_table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture

RECORD = "impacts.csv"
"""The impacts, beside the scenario of the device that made them."""

DATA = "identified.json", "identified.yaml", RECORD
"""Files that the command may write in any case."""

IDENTIFY_FILES = page_and_figure_files(["figure-impacts", "figure-record"])
"""Files that it may write as well, by their formats."""

PICKED_SHARE, DRAWN_SHARE = 0.5, 0.9
"""Shares of the time with raw signals, as measured, after which the impacts are picked, and the record is drawn."""

ANSWERED_SHARE = 0.5
"""Share of the time from the impacts on that the identification takes, as measured; random devices take the rest."""

SAME_RESTITUTION = 1e-9
"""Difference of two restitutions that a scenario has as one: beyond what times tell, and before its own limit."""

WORDS = Words("identify")


class Pages(Struct, frozen=True):
    """The formats that an identification is written in, and what is printed of it.

    Attributes
    ----------
    formats : collection of Task
        Among `IDENTIFY_FILES`.
    templates : Path, optional
        A folder whose templates come before ours.
    paper : str
        Of the PDF: a4 or letter.
    json : bool
        Whether JSON is printed, and no page is written.
    tables : bool
        Whether all numbers are printed.
    """

    formats: Collection[Task] = ()
    templates: Path | None = None
    paper: str = "a4"
    json: bool = False
    tables: bool = False


class Request(Struct, frozen=True, eq=False):
    """The inputs to identify, and the record to identify them from.

    Attributes
    ----------
    loaded : Loaded
        The scenario.
    impacts, signals : str or None
        Path of the record: of impacts, or of raw signals.
    referenced : bool
        Whether time 0 of the impacts is a maximum of the force.
    free : tuple of str
        Keys of the unknowns; both restitutions where there are none.
    command : str
        For the record of how it was made.
    """

    loaded: Loaded
    impacts: str | None = None
    signals: str | None = None
    referenced: bool = False
    free: tuple[str, ...] = ()
    command: str = ""


def outcome(request: Request, pages: Pages, say: Progress) -> CommandOutcome:
    """Identify a device from a record of its impacts, or from raw signals.

    Raises
    ------
    UsageError, ScenarioError
        If the question or the record is malformed.
    NumericalError
        If the record does not hold what is asked for.
    """
    loaded, impacts, referenced, command = request.loaded, request.impacts, request.referenced, request.command
    json, words = pages.json, Words("identify", pages.templates)
    inquiry, signals = inquiry_of(loaded.scenario, request.free, referenced), None
    say(WorkStep("reading the record", 0.0))
    if request.signals is not None:
        keys = loaded.scenario.record
        signals = read_signals(request.signals, inquiry, portion(say, 0.0, PICKED_SHARE), keys)
        record = signals.record
        if signals.shaker is not None:
            if referenced:
                raise UsageError("--clock: the record's acceleration gives the phase (leave one of them out)")
            inquiry = with_shaker(inquiry, signals.shaker, signals.picked.delay_s)
    else:
        record = read_record(str(impacts), float(inquiry.model.device.frequency_hz), keys=_of_impacts(loaded.scenario))
    files = {} if signals is None else {RECORD: _impacts_csv(signals)}
    # What is given may be the file that an earlier run wrote here, and was corrected since.
    data_files = [name for name in DATA if name != RECORD or signals is not None]
    stale = (*data_files, *file_names(pages.formats, IDENTIFY_FILES))
    others = file_names([task for task in IDENTIFY_FILES if task not in pages.formats], IDENTIFY_FILES)
    pictures: list[Picture] = []
    if signals is not None and not json:
        from vireport.identify.record_figure import record_picture

        say(WorkStep("drawing the record", PICKED_SHARE))
        pictures.append(record_picture(signals, pages.templates))
    rest = say if signals is None else portion(say, PICKED_SHARE if json else DRAWN_SHARE, 1.0)

    def outcome_of(
        opening: Opening, parts: tuple[str | Table, ...], failure: str, code: int, opened: tuple[str, ...] = ()
    ) -> CommandOutcome:
        """The outcome for a reader; a page says what is `opened` by its opening, and a terminal in numbers as well."""
        doubts = () if signals is None else record_alerts(signals.doubts)
        reading = "" if signals is None else words("read_as", signals.picked.recording, Path(record.name).name)
        text = _text(opening, reading, doubts, (*opened, *parts) if pages.tables else (), pages.templates)
        from vireport.identify.page import IdentifyReport
        from vireport.report.rendering import render_files

        say("setting the report")
        drawn = {picture.name: picture for picture in pictures}
        origin = with_pages(provenance_of(loaded, command), drawn=bool(drawn))
        name = Path(record.name).name
        said = {fact for _, fact in opening.worded(pages.templates).facts}
        more = tuple(part for part in parts if part not in said)
        report = IdentifyReport(opening, more, doubts, name, loaded, drawn, origin, pages.templates)
        written = files | render_files(report, set(pages.formats), pages.paper)
        return CommandOutcome("", text, written, failure=failure, exit_code=code, stale=stale, other_files=others)

    try:
        answer = answered(inquiry, record, referenced, portion(rest, 0.0, ANSWERED_SHARE))
    except Unidentifiable as refused:
        failure = words("refused", refused.left_open, Unknown.PHASE in inquiry.unknowns)
        if signals is None or json:
            raise NumericalError(failure) from refused
        # What was picked may be why: it is shown all the same.
        opening = open_opening(failure, signals)
        return outcome_of(opening, tuple(_signals_parts(signals, words)), failure, NumericalError.exit_code)
    shaker = signals.shaker if signals is not None else None
    scenario = _scenario_text(loaded.scenario, answer, shaker)
    rest(WorkStep("trying devices as the errors allow", ANSWERED_SHARE))
    share, held = share_that_fits(answer), held_harmonics(answer, shaker)
    identified = IdentifiedRecord(answer, record, signals, share, held)
    data = identified_data(identified, scenario, WORDS)
    written = json_bytes(keyed(data), provenance_of(loaded, command))
    files["identified.json"] = written
    if scenario is not None:
        keys = None if impacts is None else _of_impacts(loaded.scenario)
        files["identified.yaml"] = (scenario + _record_text(answer, shaker, referenced, keys)).encode()
        if impacts is not None:
            files[RECORD] = record_contents(impacts)
    failure = "" if answer.misfit.accepted else f"the data contradict the model: {WORDS('reason', answer.misfit)}"
    if json:
        return CommandOutcome(written, failure=failure, exit_code=bool(failure))
    from vireport.identify.impacts_figure import impacts_picture

    pictures.append(impacts_picture(answer, record, pages.templates))
    opened, parts = tuple(_opened(identified, words)), tuple(_parts(identified, words))
    return outcome_of(identified_opening(identified), parts, failure, bool(failure), opened)


def _text(
    opening: Opening,
    reading: str,
    doubts: tuple[Alert, ...],
    parts: Iterable[str | Table],
    templates: Path | None = None,
) -> str:
    """What a terminal says: the opening, how signals were read, what may be wrong with what was given, and tables."""
    lines = (*opening.worded(templates).lines, reading, *(alert.words(templates) for alert in doubts))
    answer = "\n".join(filter(None, lines))
    return "\n\n".join([answer, *filter(None, [plain_text(parts)])]) + "\n"


def _of_impacts(scenario: Scenario) -> LayoutBlock | None:
    """How a file of impacts is read: by the scenario's `record:` block, if it says which column has membranes."""
    columns = scenario.record.columns if scenario.record is not None else None
    return scenario.record if columns is not None and columns.membrane is not None else None


def _record_text(
    answer: Identification, shaker: ShakerMotion | None, referenced: bool, keys: LayoutBlock | None
) -> str:
    """What a scenario says of the record beside it, and of its clock where that knows the force."""
    record: dict[str, object] = {"impacts": RECORD} | (
        {} if keys is None else {"record": keys.model_dump(mode="json", exclude_none=True)}
    )
    if shaker is not None:
        error = next(prior.deviation for prior in answer.inquiry.priors if prior.unknown is Unknown.PHASE)
        record["force_maximum_s"] = shaker.maximum_s
        record["force_maximum_error_s"] = float(error / (2 * np.pi * shaker.frequency_hz))
    elif referenced:
        record["force_maximum_s"] = 0.0
    return as_yaml({"measured": [record]})


def _impacts_csv(signals: Signals) -> bytes:
    """What was picked, as a record of impacts that can be corrected and given to the command again."""
    picked = signals.picked
    rows = (
        f"{time:.9f},{'bottom' if wall > 0 else 'top'},{error:.3g}\n"
        for time, wall, error in zip(picked.times, picked.walls, picked.errors, strict=True)
    )
    return ("time_s,membrane,standard_error_s\n" + "".join(rows)).encode()


def _signals_parts(signals: Signals, words: Words) -> Iterator[str | Table]:
    picked, shaker = signals.picked, signals.shaker
    yield words("heard", picked, picked.heard, picked.recording, Path(picked.recording.name).name)
    for finding in picked.findings:
        yield words("finding", finding)
    if shaker is None:
        return
    yield words("shaker", shaker)
    rows = [
        (
            str(harmonic.order),
            measured(harmonic.percent, harmonic.percent_error),
            rounded_text(harmonic.percent_error, ROUGHLY),
            measured(harmonic.phase_deg, harmonic.phase_error_deg),
            rounded_text(harmonic.phase_error_deg, ROUGHLY),
        )
        for harmonic in shaker.harmonics
        if harmonic.significant
    ]
    if rows:
        yield worded_table(words, "harmonics", "nnnnn", rows)


def _scenario_text(scenario: Scenario, answer: Identification, shaker: ShakerMotion | None) -> str | None:
    """The scenario with what was identified, its intervals as tolerances; None where that is no valid one."""
    values = {x: item for item in answer.identified if (x := item.unknown.design_input) is not None}
    if not values or any(not x.limits[0] <= item.value <= x.limits[1] for x, item in values.items()):
        return None
    data = to_dict(scenario)
    tolerances = data["tolerances"] or {}
    device, fitted = data["device"], answer.fit
    assert isinstance(fitted, Fitted)
    if any(x in RESTITUTIONS for x in values):
        # Of one membrane alone the other stays; of both together their difference does.
        bottom, top = (float(fitted.adjusted.model.device.value_of(x)) for x in RESTITUTIONS[1:])
        same = abs(bottom - top) < SAME_RESTITUTION
        one = same and DesignInput.RESTITUTION in values
        device.update(
            restitution=(bottom + top) / 2 if one else None,
            restitution_bottom=None if one else bottom,
            restitution_top=None if one else bottom if same else top,
        )
        # A tolerance of what the file no longer gives has no meaning.
        for x in RESTITUTIONS:
            tolerances.pop(x.value, None)
            tolerances.pop(percent_key(x), None)
    normal = tolerances.get("distribution") == Distribution.NORMAL.value
    for x, item in values.items():
        *blocks, key = x.path.split(".")
        if x not in RESTITUTIONS:
            reduce(dict.__getitem__, blocks, data)[key] = item.value
        tolerances.pop(percent_key(x), None)
        # Of a normal distribution a tolerance is three standard deviations.
        tolerances[x.value] = 3 * item.error if normal else item.half
    if shaker is not None:
        # With the errors that they were taken with, among them what the scenario said of them.
        for prior in answer.inquiry.priors:
            if prior.unknown in OF_SHAKER:
                varied = DesignInput(prior.unknown.value)
                data["excitation"][varied.value] = prior.value
                tolerances.pop(percent_key(varied), None)
                tolerances[varied.value] = (3 if normal else NORMAL_95) * prior.deviation
        data["excitation"]["harmonics"] = [
            {"order": item.order, "percent": item.percent, "phase_deg": item.phase_deg}
            for item in shaker.harmonics
            if item.significant
        ]
    data["tolerances"] = tolerances if "tolerances" not in keys_left_out(Scenario) else None
    # What was there is of another record, in another folder.
    data["measured"] = data["record"] = data["excitation"]["record"] = None
    text = as_yaml(data)
    loads(text, "identified.yaml")
    return text


def _opened(identified: IdentifiedRecord, words: Words) -> Iterator[str]:
    """What the opening has as well: here with all numbers, and as reasons."""
    answer = identified.answer
    fitted, misfit = answer.fit, answer.misfit
    if isinstance(fitted, Fitted):
        missed = sum(gap.missed_s is not None for gap in fitted.gaps)
        weighted = fitted.adjusted.equations.relative is not None
        counts = (missed, len(fitted.false), fitted.lost)
        summary = words("summary", len(fitted.impacts), answer.timing_error_s, *counts, weighted)
        if misfit.accepted:
            p = "" if misfit.p_value is None else f" (p = {rounded_text(misfit.p_value, ROUGHLY)})"
            yield f"{summary} {words('reason', misfit).capitalize()}{p}."
        else:
            yield summary
    if not misfit.accepted:
        yield f"The data contradict the model: {words('reason', misfit)}."
    if identified.share is not None:
        yield words("devices", identified.share)
    if identified.held is not None:
        yield words("held", identified.held)


def _parts(identified: IdentifiedRecord, words: Words) -> Iterator[str | Table]:
    """The parts of the report: identified inputs, what the record does not show, and picked impacts."""
    answer, unused = identified.answer, identified.record.unused
    misfit = answer.misfit
    if answer.rounding is not None:
        yield words("rounded", answer.rounding)
    rows = [
        (
            words("named_in", adjustment.unknown),
            measured(adjustment.value, adjustment.error),
            rounded_text(adjustment.error, ROUGHLY),
            *(measured(end, adjustment.error) for end in (adjustment.low, adjustment.high)),
        )
        for adjustment in answer.identified
    ]
    if rows:
        yield worded_table(words, "identified", "tnnnn", rows)
    unseen = misfit.untested, misfit.swapped_untested, misfit.distortion_untested
    if misfit.accepted and (untested := words("untested", *unseen)):
        yield untested
    if misfit.accepted and misfit.hidden:
        yield words("hidden", misfit.hidden, most_hidden(misfit.hidden))
    if unused:
        yield words("not_used", unused)
    if identified.signals is not None:
        yield from _signals_parts(identified.signals, words)
