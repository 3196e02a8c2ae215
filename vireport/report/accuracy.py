"""The section on accuracy and run time: what each method reaches and how fast, and what failed."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.report.pages import Block, Subheading, content
from vireport.trust import WorkPrecision, measurements, ranking


def accuracy(work: WorkPrecision) -> Iterator[Block]:
    """Blocks of the section."""
    yield from content(measurements(work))
    if work.benchmark is not None:
        yield Subheading("The fastest method")
        yield from content(ranking(work))
