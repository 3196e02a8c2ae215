"""What made a report, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vireport.study.provenance import Provenance
from vireport.text.said import BETWEEN
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words


def made_with(provenance: Provenance, overrides: Sequence[str] | None, templates: Path | None = None) -> Table:
    """Set what made a report, and of what.

    Parameters
    ----------
    provenance : Provenance
    overrides : sequence of str or None
        What was set over the scenario; None where there are several, whose hashes stand above.
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    say = Words("provenance", templates)
    scenario, digest, digests, override, command, python, libraries = say("made_of").split(BETWEEN)
    rows = [("vireport", provenance.version)]
    if overrides is None:
        rows += [(digests, provenance.scenario_sha256)]
    else:
        rows += [(scenario, provenance.scenario_name), (digest, provenance.scenario_sha256)]
        rows += [(override, text) for text in overrides]
    rows += [(command, provenance.command), (python, provenance.python)]
    rows += [(libraries, ", ".join(map(" ".join, provenance.libraries)))]
    rows += [("SOURCE_DATE_EPOCH", provenance.timestamp)] if provenance.timestamp else []
    return worded_table(say, "made_with", "tc", rows)
