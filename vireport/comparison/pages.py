"""The report of a comparison: what differs in a sentence each, all numbers side by side, the figures, the origin."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from vireport.alerts import AlertCode, Severity
from vireport.comparison.comparison import ACROSS, FEW_NAMES, FIGURES, Comparison, Setting, columns, left_out
from vireport.comparison.differences import Difference, digits_apart, listed
from vireport.comparison.quantities import Entry
from vireport.figures import OUTSIDE
from vireport.gate import SWEEP_END, Fact, Status, Verdict
from vireport.report import Block, Paragraph, ReportModel, section
from vireport.report import context as context_pages
from vireport.study import Provenance, with_pages
from vireport.text import ABSENT, Column, Table, capital, exact, numbers, significant, texts, words

if TYPE_CHECKING:
    from vireport.figures import Picture


def build_comparison_report(comparison: Comparison, pictures: Sequence[Picture], provenance: Provenance) -> ReportModel:
    """Put a comparison into words, tables and pictures, for the templates of the report.

    Parameters
    ----------
    comparison : Comparison
    pictures : sequence of Picture
        Of `compare_figures.compare_pictures`.
    provenance : Provenance
        Of `comparison_provenance`.
    """
    origin = with_pages(provenance, drawn=bool(pictures))
    return ReportModel(
        title=_title(comparison),
        verdict=comparison_verdict(comparison),
        sections=(
            *section("differences", "What differs", _differences(comparison)),
            *section("side-by-side", "Side by side", _side_by_side(comparison)),
            *section("settings", "How the scenarios differ", _settings(comparison)),
            *section("figures", "Figures", context_pages.figures(pictures)),
            *section("alerts", "Alerts", _alerts(comparison)),
            *section("left-out", "Left out, and why", _left_out(comparison)),
            *section("provenance", "Provenance", _provenance(comparison, origin)),
        ),
        pictures=tuple(pictures),
        live="",
        scenario_text=_scenario_text(comparison),
        provenance=origin,
    )


def comparison_verdict(comparison: Comparison) -> Verdict:
    """What a comparison comes to: how much differs, what most, and the verdict on each scenario."""
    verdicts = [(name, study.verdict) for name, study in zip(comparison.names, comparison.studies, strict=True)]
    facts = tuple(Fact(name, verdict.word, verdict.headline, verdict.status) for name, verdict in verdicts)
    differing, count = len(comparison.differences), len(comparison.quantities)
    if not differing:
        headline = f"All {count} quantities are the same in all scenarios."
        return Verdict(Status.NEUTRAL, "No difference", headline, facts)
    word = f"{differing} of {count} quantities differ"
    return Verdict(Status.NEUTRAL, word, _plain(_headline(comparison.differences)), facts)


def _headline(differences: Sequence[Difference]) -> str:
    """What only some scenarios have, in short, and what changed most of the rest."""
    some = list(dict.fromkeys(x.of.brief or x.of.subject for x in differences if x.change is None))
    lead = f"In some scenarios only: {listed(some)}. " if some else ""
    sentences = (difference.sentence for difference in differences if difference.change is not None)
    return f"{lead}{next(sentences, '')}".strip()


def _title(comparison: Comparison) -> str:
    if len(comparison.names) <= FEW_NAMES:
        return f"Comparison of {listed(comparison.names)}"
    return f"Comparison of {len(comparison.names)} scenarios"


def _plain(text: str) -> str:
    """A text in which only U_ave has a subscript: the names of scenarios are not markup."""
    return re.sub(r"(?<!\w)([^\W\d_])_(?!ave\b)", "\\1\u2060_", text.replace("*", "\u2217"))


def _differences(comparison: Comparison) -> Iterator[Block]:
    if not comparison.differences:
        yield Paragraph("Nothing differs by more than rounding.")
        return
    yield Paragraph(
        "What only some scenarios have comes first, then what changed most. Apart is the largest value less the "
        "smallest, over the largest size."
    )
    yield Paragraph(_places(comparison))
    pairs = zip(comparison.names, comparison.studies, strict=True)
    if outside := [name for name, study in pairs if not study.solution.within_membrane]:
        which = "all scenarios" if len(outside) == len(comparison.names) else listed(outside)
        yield Paragraph(_plain(f"Voltages of {which}: {OUTSIDE} ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY})."))
    rows = tuple((difference.apart, _plain(difference.sentence)) for difference in comparison.differences)
    yield Table("Differences, the largest first", (*numbers("Apart"), *texts("In words")), rows)


def _places(comparison: Comparison) -> str:
    """In what places along the sweep are compared."""
    sweeps = [study.solution.sweep for study in comparison.studies if study.solution.sweep is not None]
    axis, also = comparison.axes.always[0], comparison.axes.shared
    if not sweeps:
        return "No scenario has a sweep: the design points and their margins are compared."
    if axis != "d":
        text = f"All sweep the {axis.quantity}, in which their critical points are compared"
        return f"{text}; also in *d*, which is not the same multiple of it in all." if also else f"{text}."
    swept = list(dict.fromkeys(sweep.parameter.quantity for sweep in sweeps))
    text = f"The sweeps are of different parameters ({listed(swept)}): places are compared in *d*, which all have"
    shared = [f"the {axis.quantity}" for axis in also if axis != "d"]
    return f"{text}, and in {listed(shared)} where scenarios share that." if shared else f"{text}."


def _side_by_side(comparison: Comparison) -> Iterator[Block]:
    names = comparison.names
    for chosen in columns(len(names)):
        rows = tuple(_row(quantity, chosen) for quantity in comparison.quantities)
        part = f": {listed(names[chosen])}" if len(names) > ACROSS else ""
        reasons = _reasons(comparison, chosen)
        yield Table(
            _plain(f"Critical points, stable ranges, margins and voltages{part}"),
            (*texts("Quantity"), *numbers(*map(_plain, names[chosen]), "Apart")),
            rows,
            _plain(reasons),
        )


def _row(quantity: Difference, chosen: slice) -> tuple[str, ...]:
    digits = digits_apart([value for value in quantity.values if value is not None], "1")
    cells = [_cell(entry, digits) for entry in quantity.entries[chosen]]
    return (_plain(quantity.heading), *cells, quantity.apart)


def _cell(entry: Entry, digits: int) -> str:
    if entry.value is None:
        return "none" if entry.finding else ABSENT
    note = "sweep" if entry.note == SWEEP_END else entry.note
    return f"{significant(entry.value, digits)} ({note})" if note else significant(entry.value, digits)


def _reasons(comparison: Comparison, chosen: slice) -> str:
    """Why there are dashes."""
    reasons: dict[str, dict[str, None]] = {}
    for quantity in comparison.quantities:
        for name, entry in zip(comparison.names[chosen], quantity.entries[chosen], strict=True):
            if entry.value is None and not entry.finding:
                reasons.setdefault(entry.note, {})[name] = None
    texts = "; ".join(f"{reason} ({listed(list(names))})" for reason, names in reasons.items())
    return f"A dash: {texts}." if texts else ""


def _settings(comparison: Comparison) -> Iterator[Block]:
    if not comparison.settings:
        yield Paragraph("They do not: all values are the same.")
        return
    names = comparison.names
    for chosen in columns(len(names)):
        rows = tuple((setting.path, *_written(setting, chosen)) for setting in comparison.settings)
        head = (Column("Key", "code"), *numbers(*map(_plain, names[chosen])))
        yield Table("Values that are not the same in all scenarios", head, rows)


def _written(setting: Setting, chosen: slice) -> Iterator[str]:
    for value in setting.values[chosen]:
        if value is None:
            yield ABSENT
        elif isinstance(value, float):
            yield exact(value)
        else:
            yield ", ".join(map(exact, value)) if isinstance(value, list) else str(value)


def _alerts(comparison: Comparison) -> Iterator[Block]:
    names: dict[tuple[bool, str, str, str], list[str]] = {}
    for name, study in zip(comparison.names, comparison.studies, strict=True):
        for alert in study.alerts:
            key = (alert.severity is not Severity.WARNING, alert.code, capital(alert.severity), words(alert.title))
            names.setdefault(key, []).append(name)
    if not names:
        yield Paragraph("None.")
        return
    rows = tuple((*key[1:], _plain(listed(whose))) for key, whose in sorted(names.items()))
    note = "The report of a scenario by itself has the cause with its numbers, and the remedy."
    yield Table("Alerts of the scenarios", texts("Code", "Severity", "Alert", "Scenarios"), rows, note)


def _left_out(comparison: Comparison) -> Iterator[Block]:
    rows = [(f"{capital(figure)} of {name}", why) for figure in FIGURES for name, why in left_out(comparison, figure)]
    rows.append(("Table 1, every motion, equations", "They are in the report of a scenario by itself (vireport run)"))
    yield Table("Not in this report", texts("What", "Why"), tuple((_plain(what), capital(why)) for what, why in rows))


def _provenance(comparison: Comparison, provenance: Provenance) -> Iterator[Block]:
    pairs = list(zip(comparison.names, comparison.studies, strict=True))
    if any(study.loaded.overrides for _, study in pairs):
        columns = (*texts("Scenario"), Column("File", "code"), Column("Set over it", "code"))
        origin = [
            (_plain(name), _file(study.loaded.document.name), " ".join(study.loaded.overrides) or ABSENT)
            for name, study in pairs
        ]
        yield Table("Scenarios", columns, tuple(origin))
    hashes = [(_plain(name), study.loaded.sha256) for name, study in pairs]
    caption = "SHA-256 of the scenarios, with what was set over them"
    yield Table(caption, (*texts("Scenario"), Column("SHA-256", "code")), tuple(hashes))
    yield context_pages.made_with(provenance, [("SHA-256 of the lines above", provenance.scenario_sha256)])


def _file(name: str) -> str:
    return PurePath(name).name


def _scenario_text(comparison: Comparison) -> str:
    """The files, each once, as YAML documents; the one file as it stands."""
    documents = [study.loaded.document for study in comparison.studies]
    files = dict.fromkeys((_file(document.name), document.text) for document in documents)
    if len(files) == 1:
        return next(iter(files))[1]
    return "\n---\n".join(f"# {name}\n{text.rstrip()}" for name, text in files) + "\n"
