"""The sections around the results: alerts, scenario, figures, the paper, what was left out, provenance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from vireport.physics import Device
from vireport.report.pages import Block, Figure, Listing, Notice, Paragraph
from vireport.scenario import UNIT_OF_SWEPT, Parameter, inputs
from vireport.study import Provenance, Study
from vireport.text import Column, Table, capital, exact, numbers, significant, texts, words
from vireport.trust import PAPER, ComparedRow, PaperComparison

if TYPE_CHECKING:
    from vireport.figures import Picture

SYMBOLS = {
    "device.capsule_mass_kg": "*M*",
    "device.ball_mass_kg": "*m*",
    "device.restitution": "*r*",
    "device.length_m": "*s*",
    "device.membrane.stiffness": "*K*",
    "device.membrane.exponent": "*h*",
    "device.membrane.active_radius_m": "*R*_c",
    "device.membrane.ball_radius_m": "*r*_b",
    "device.membrane.bias_voltage_v": "*U*_in",
    "excitation.amplitude_n": "*F*",
    "excitation.frequency_hz": "*f* = *ω*/2π",
    "inclination_deg": "*β*",
    "gravity_m_s2": "*g*",
    "period_ratio": "*n*",
}

UNITS = {"1": "", "deg": "°", "m/s^2": "m/s²", "N/m^h": "N/mʰ"}
"""Units of the scenario format that are set in another way."""

NOT_A_QUANTITY = ("schema_version", "title")

LONGEST_LISTING = 8000
"""Characters of a scenario that are printed; a longer one is attached to the PDF all the same."""


def alerts(study: Study) -> Iterator[Block]:
    """What a reader must know before acting on the numbers."""
    if not study.alerts:
        yield Paragraph("None.")
    for alert in study.alerts:
        yield Notice(alert.severity, alert.code, words(alert.title), words(alert.cause), words(alert.remedy))


def scenario(study: Study) -> Iterator[Block]:
    """The scenario as understood, and what follows from it."""
    yield Table(
        "Values, and where they come from",
        (*texts("Quantity", "Symbol"), *numbers("Value"), *texts("Unit", "Origin"), Column("Key", "code")),
        tuple(_values(study)),
    )
    yield _derived_table(study)


def _values(study: Study) -> Iterator[tuple[str, ...]]:
    """A row for every value of a scenario, in the order of the format."""
    for entry in inputs(study.scenario):
        if entry.path not in NOT_A_QUANTITY:
            unit = study.solution.parameter.unit if entry.unit == UNIT_OF_SWEPT else UNITS.get(entry.unit, entry.unit)
            symbol, origin = SYMBOLS.get(entry.path, ""), _origin(study, entry.path)
            yield entry.title, symbol, _written(entry.value), unit, origin, entry.path


def _written(value: object) -> str:
    """A value as a scenario has it."""
    if isinstance(value, tuple):
        return ", ".join(map(exact, value)) or "none"
    if isinstance(value, bool):
        return str(value).lower()
    return exact(value) if isinstance(value, float) else str(value)


def _origin(study: Study, path: str) -> str:
    """Whether a value was given, and where, or is a default; and whether it is the sweep's design point."""
    origin = "given" if path in study.loaded.given else "default"
    if study.loaded.is_set_over(path):
        origin = "set over the scenario"
    swept = study.solution.sweep is not None and path.rpartition(".")[2] == study.solution.sweep.parameter
    return f"{origin}; design point" if swept else origin


def _derived_table(study: Study) -> Table:
    device, sweep = study.solution.device, study.solution.sweep
    parameter = study.solution.parameter
    design, note = getattr(device, parameter), ""
    points = {} if design is None else {"at the design point": float(design)}
    if sweep is not None:
        points |= {"from": sweep.start, "to": sweep.end}
        swept = parameter
        ends = f"{swept.show(sweep.start)} and {swept.show(sweep.end)}"
        note = f"From and to are the ends of the sweep, *{swept.symbol}* = {ends}."
    columns = [derived(device, parameter, value) for value in points.values()]
    rows = [
        (name, symbol, *(significant(column[i][2], 8) for column in columns), unit)
        for i, (name, symbol, _, unit) in enumerate(columns[0])
    ]
    head = (*texts("Quantity", "Symbol"), *numbers(*points), *texts("Unit"))
    return Table("What follows from them", head, tuple(rows), note)


def derived(device: Device, parameter: Parameter, value: float) -> tuple[tuple[str, str, float, str], ...]:
    """Name, symbol, value and unit of what follows from a device where one parameter has a value."""
    x = device.at(parameter, value)
    d, gbar = device.groups(parameter, value)
    frequency, force = x[Parameter.FREQUENCY], x[Parameter.AMPLITUDE]
    shaker = device.shaker(parameter, value)
    return (
        ("Unit of length", "*x*_c", force / (4 * device.capsule_mass_kg * frequency**2), "m"),
        ("Unit of velocity", "*y*_c", float(device.velocity_unit(parameter, value)), "m/s"),
        ("Unit of time", "*t*_c", 1 / (2 * frequency), "s"),
        ("Dimensionless length", "*d* = *s*/*x*_c", float(d), ""),
        ("Dimensionless gravity", "*ḡ*", float(gbar), ""),
        ("Acceleration amplitude of the capsule", "*F*/*M*", shaker.acceleration_m_s2, "m/s²"),
        ("the same over 9.80665 m/s²", "", shaker.acceleration_g, "g"),
        ("Stroke of the capsule, end to end", "2*F*/(*Mω*²)", shaker.stroke_m, "m"),
        ("Force amplitude on the capsule", "*F*", shaker.force_n, "N"),
    )


def figures(pictures: Sequence[Picture]) -> Iterator[Block]:
    """The pictures, whole."""
    for x in pictures:
        title = f"{x.title.rstrip('.')}."
        yield Figure(x.name, title, x.caption, x.alt, x.png, x.width, x.height)


def paper(compared: PaperComparison | None) -> Iterator[Block]:
    """The paper's numbers beside ours."""
    if compared is None:
        return
    yield Paragraph(
        f"The scenario is one of those of {PAPER}: {compared.case}. Ours are computed here. A printed "
        "phase may belong to either impact and to either of two mirror images; the row says to which."
    )
    marks = {True: "agrees", False: "differs", None: ""}
    yield Table(
        "Numbers",
        (*texts("Quantity"), *numbers("Printed", "Computed"), *texts("Outcome", "Remark")),
        tuple((row.quantity, row.printed, row.ours, marks[row.agrees], row.remark) for row in compared.rows),
    )
    if compared.types:
        yield Table(
            "Types of motion along the branches of Table 1",
            texts("Motion", "Printed", "Computed", "Outcome"),
            tuple((row.quantity, row.printed, row.ours, _outcome(row)) for row in compared.types),
        )
    yield Table(
        "Slips in the text that bear on this scenario",
        texts("Where", "Printed", "Meant", "Why"),
        tuple((slip.place, slip.printed, slip.meant, slip.why) for slip in compared.misprints),
    )


def _outcome(row: ComparedRow) -> str:
    return ": ".join(filter(None, ("agrees" if row.agrees else "differs", row.remark)))


def left_out(study: Study, compared: PaperComparison | None) -> Iterator[Block]:
    """What is not in the report, and why."""
    rows = [(capital(words(step.what)), capital(words(step.why))) for step in study.plan.left_out]
    if compared is None:
        rows.append(("Comparison with the paper's numbers", "The scenario is none of the paper's"))
    why = (
        "The analysis is of motions with one impact on each membrane in every period; beyond a period "
        "doubling, for instance, there are others"
    )
    if study.atlas is not None:
        rows.append(("Motions with more impacts or longer periods than the limits, sticking, chaos", why))
    elif study.crosscheck is None:
        rows.append(("Motions of other types: longer periods, more impacts in a period, sticking, chaos", why))
    else:
        rows.append(("Stability ranges of motions of other types", f"{why}: the simulation shows some"))
    yield Table("Not in this report", texts("What", "Why"), tuple(rows))


def made_with(origin: Provenance, scenario: Sequence[tuple[str, str]]) -> Table:
    """The version, what the scenario's rows say, the command and the libraries."""
    rows = [
        ("vireport", origin.version),
        *scenario,
        ("Command", origin.command),
        ("Python", origin.python),
        ("Libraries", ", ".join(f"{name} {version}" for name, version in origin.libraries)),
    ]
    if origin.timestamp is not None:
        rows.append(("SOURCE_DATE_EPOCH", origin.timestamp))
    return Table("Made with", (Column("What"), Column("Value", "code")), tuple(rows))


def provenance(study: Study, origin: Provenance) -> Iterator[Block]:
    """Where the numbers come from, and the scenario itself."""
    scenario = [
        ("Scenario", origin.scenario_name),
        ("SHA-256 of the scenario", origin.scenario_sha256),
        *(("Set over it", text) for text in study.loaded.overrides),
    ]
    yield made_with(origin, scenario)
    text = study.loaded.document.text
    if len(text) <= LONGEST_LISTING:
        yield Listing("The scenario as given", text)
