"""The files that commands read: a scenario, or the earlier run that a results.json or a report is of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vireport.scenario.loading import Loaded
    from vireport.study.earlier import Earlier


def read_earlier_run(path: str) -> Earlier | None:
    """Read the earlier run whose results.json or report a path is; None where it is that of a scenario.

    Raises
    ------
    UsageError
        Where the results lack what is compared.
    """
    if Path(path).suffix.lower() not in (".json", ".html", ".pdf"):
        return None  # what reads it need not be imported
    from vireport.study.earlier import earlier_run

    earlier = earlier_run(path)
    if earlier is not None:
        from vireport.report.changes.baseline import require_comparable

        require_comparable(earlier.results, earlier.file)
    return earlier


def read_scenario(
    path: str, overrides: Sequence[str] | None, allow_outside: bool = False
) -> tuple[Loaded, Earlier | None]:
    """Read the scenario of a file, and the earlier run that the file is of, if it is of one.

    Raises
    ------
    UsageError, ScenarioError
        Where the file cannot be read, or has mistakes.
    """
    earlier = read_earlier_run(path)
    if earlier is not None:
        return earlier.loaded(overrides or (), allow_outside), earlier
    from vireport.scenario.loading import load

    return load(path, overrides or (), allow_outside), None
