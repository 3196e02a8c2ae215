"""The report of a study: what it says, in which order.

Builds the one model from which both templates set the page; nothing here draws, renders or writes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from vireport.report import context as context_pages
from vireport.report import results as results_pages
from vireport.report.acceptance import acceptance
from vireport.report.certificates import certification
from vireport.report.energy import energy
from vireport.report.equations import equations
from vireport.report.pages import Block, ReportModel, Subheading, content, section
from vireport.report.simulation import simulation
from vireport.study import Provenance, Study, with_pages
from vireport.trust import compare_with_paper, comparison_with_rigid, measurements, ranking, solvers_on_stiff_membranes

if TYPE_CHECKING:
    from vireport.figures import Picture

UNTITLED = "Vibro-impact energy harvester"
"""Title of a scenario that has none."""


def _certificates(study: Study) -> Iterable[Block]:
    if study.certificates is None or study.solution.sweep is None:
        return ()
    return certification(study.certificates, study.solution.sweep.parameter)


def _motions(study: Study) -> Iterable[Block]:
    if study.atlas is None:
        return ()
    from vireport.report.motions import motions

    return motions(study)


def _accuracy(study: Study) -> Iterator[Block]:
    """What each method reaches and how fast, and what failed."""
    if study.work is None:
        return
    yield from content(measurements(study.work))
    if study.work.benchmark is not None:
        yield Subheading("The fastest method")
        yield from content(ranking(study.work))


def _compliant(study: Study) -> Iterator[Block]:
    """Whether the rigid model is good enough, and how solvers cope with stiff membranes."""
    if study.compliance is None:
        return
    yield from content(comparison_with_rigid(study.compliance))
    if study.compliance.runs:
        yield Subheading("Solvers on the stiff equation")
        yield from content(solvers_on_stiff_membranes(study.compliance))


def build_report(study: Study, pictures: Sequence[Picture], provenance: Provenance) -> ReportModel:
    """Put everything that is known about a scenario into words, tables and pictures.

    Parameters
    ----------
    study : Study
    pictures : sequence of Picture
        In the order in which they are shown; none is left out.
    provenance : Provenance
    """
    compared = compare_with_paper(study.solution)
    origin = with_pages(provenance, drawn=bool(pictures))
    return ReportModel(
        title=study.scenario.title or UNTITLED,
        verdict=study.verdict,
        sections=(
            *section("acceptance", "Acceptance", acceptance(study)),
            *section("alerts", "Alerts", context_pages.alerts(study)),
            *section("scenario", "Scenario", context_pages.scenario(study)),
            *section("table-1", "Stability along the sweep", results_pages.table_1(study)),
            *section("critical-points", "Critical points", results_pages.critical_points(study)),
            *section("design-point", "Design point", results_pages.design_point(study)),
            *section("figures", "Figures", context_pages.figures(pictures)),
            *section("energy", "Voltage", energy(study)),
            *section("simulation", "Simulation", simulation(study)),
            *section("motions", "Motions of other impact sequences", _motions(study)),
            *section("certificates", "Proven enclosures", _certificates(study)),
            *section("accuracy", "Error against run time", _accuracy(study)),
            *section("compliant", "Compliant membranes", _compliant(study)),
            *section("equations", "Equations", equations(study)),
            *section("paper", "The paper\u2019s numbers", context_pages.paper(compared)),
            *section("left-out", "Left out, and why", context_pages.left_out(study, compared)),
            *section("provenance", "Provenance", context_pages.provenance(study, origin)),
        ),
        scenario_text=study.loaded.document.text,
        provenance=origin,
    )
