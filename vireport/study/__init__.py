"""What is done for a scenario: its plan, its results, and the files for machines."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.study.plan import (
    ALL_FORMATS,
    FIGURE_FORMATS,
    FIGURES,
    FORMATS,
    Addition,
    Task,
    plan,
    refuse_special,
    refuse_undecidable,
    require_proofs,
    require_reference,
)
from vireport.study.provenance import Provenance, provenance_of, with_pages
from vireport.study.results import (
    SCHEMA_VERSION,
    SWEEP_END,
    branches_csv,
    csv_bytes,
    json_bytes,
    margin_data,
    motion_columns,
    worst_scenario,
)
from vireport.study.study import (
    Study,
    analyse,
    recheck,
    recheck_disturbances,
    require_study,
    results,
    results_json,
    sweep_of,
    with_certificates,
)

if TYPE_CHECKING:
    from vireport.study.earlier import Earlier, earlier_run, read_earlier
    from vireport.study.measured import MeasuredAt, ShownImpacts, measured_data, measured_of, require_records
else:
    __getattr__ = deferred(__name__, "earlier", "measured")

__all__ = [
    "ALL_FORMATS",
    "FIGURES",
    "FIGURE_FORMATS",
    "FORMATS",
    "SCHEMA_VERSION",
    "SWEEP_END",
    "Addition",
    "Earlier",
    "MeasuredAt",
    "Provenance",
    "ShownImpacts",
    "Study",
    "Task",
    "analyse",
    "branches_csv",
    "csv_bytes",
    "earlier_run",
    "json_bytes",
    "margin_data",
    "measured_data",
    "measured_of",
    "motion_columns",
    "plan",
    "provenance_of",
    "read_earlier",
    "recheck",
    "recheck_disturbances",
    "refuse_special",
    "refuse_undecidable",
    "require_proofs",
    "require_records",
    "require_reference",
    "require_study",
    "results",
    "results_json",
    "sweep_of",
    "with_certificates",
    "with_pages",
    "worst_scenario",
]
