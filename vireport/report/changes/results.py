"""What `vireport compare --exit-code --json` prints, as records."""

from __future__ import annotations

from typing import Any

from vireport.base.records import ResultsBlock


class ChangeData(ResultsBlock, frozen=True, kw_only=True):
    """A quantity that has changed since an earlier run.

    Attributes
    ----------
    group, what
        what it is about, and what it is
    before, after
        its values, in `unit`; null where there is none
    unit
        "" where it has none
    change : 1
        share of the larger value; null where a value is no number
    """

    group: str
    what: str
    before: Any
    after: Any
    unit: str
    change: float | None


class ChangesData(ResultsBlock, frozen=True, kw_only=True):
    """What has changed since an earlier run.

    Attributes
    ----------
    changed, tolerance
        whether anything has, and the relative tolerance
    changes
        what has
    """

    changed: bool
    tolerance: float
    changes: list[ChangeData]
