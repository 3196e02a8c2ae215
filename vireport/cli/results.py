"""What `vireport check --json` prints, as records."""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from vireport.base.errors import ScenarioError
from vireport.base.records import ResultsBlock
from vireport.study.result_records import AlertData


class MistakeData(ResultsBlock, frozen=True, kw_only=True):
    """A mistake in a scenario.

    Attributes
    ----------
    file, line
        where it is; null for one in `--set`
    path, message
        the dotted key, and what is wrong with what is allowed
    """

    file: str | None
    line: int | None
    path: str
    message: str


class StepData(ResultsBlock, frozen=True, kw_only=True):
    """A step of a run.

    Attributes
    ----------
    step, what
        its name, and what it is
    runs, why
        whether a run with the formats of `--format` does it, and why or why not
    """

    step: str
    runs: bool
    what: str
    why: str


class CheckedData(ResultsBlock, frozen=True, kw_only=True):
    """What is wrong with a file, or what a run of it would do.

    Attributes
    ----------
    valid, kind
        whether it can be used, and what it is, `scenario` or `map`; the latter null where it cannot be used
    mistakes, more
        the first 20, and the number of others; the latter absent of a valid file
    alerts
        values that may be in another unit (VR015), [as in results.json](results.md#requirements-and-alerts); absent
        where there are mistakes
    steps
        of a run
    """

    valid: bool
    kind: str | None
    mistakes: list[MistakeData]
    more: int | UnsetType = UNSET
    alerts: list[AlertData] | UnsetType = UNSET
    steps: list[StepData]


def mistakes_data(error: ScenarioError) -> CheckedData:
    """What is wrong with a file that cannot be used."""
    mistakes = [
        MistakeData(
            file=error.name if mistake.line else None,
            line=mistake.line or None,
            path=mistake.path,
            message=mistake.message,
        )
        for mistake in error.mistakes
    ]
    return CheckedData(valid=False, kind=None, mistakes=mistakes, more=error.more, steps=[])
