"""Reports of progress: long work calls a function with each step as it begins."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self


class WorkStep(str):
    """The step of the work that begins now, as text, and how much of the whole work is done by then.

    It is text, so that whoever only prints what they are told need not know of it.

    Attributes
    ----------
    name : str
        What is done, without its number.
    share : float or None
        Of the whole work, from 0 to 1; None where it is not known.
    number : str
        Among alike ones, such as "3 of 12"; "" where it has none.
    """

    name: str
    share: float | None
    number: str

    def __new__(cls, name: str, share: float | None = None, number: str = "") -> Self:
        """Make the step, whose text is its name with its number."""
        step = super().__new__(cls, f"{name}, {number}" if number else name)
        step.name, step.share, step.number = name, share, number
        return step

    @classmethod
    def of(cls, text: str) -> WorkStep:
        """A step of what may be plain text."""
        return text if isinstance(text, WorkStep) else cls(text)


Progress = Callable[[str], None]


def counted(name: str, number: int, of: int) -> WorkStep:
    """A step of several alike ones, by its number from 1, as it begins."""
    return WorkStep(name, (number - 1) / of, f"{number} of {of}")


def portion(progress: Progress, first: float, last: float) -> Progress:
    """The progress of a part of some work, which reaches from one share of the whole to another.

    Examples
    --------
    >>> told = []
    >>> say = portion(told.append, 0.5, 0.7)
    >>> say(counted("solving", 2, 4))
    >>> told[0], told[0].share
    ('solving, 2 of 4', 0.55)
    """

    def say(text: str) -> None:
        step = WorkStep.of(text)
        share = None if step.share is None else first + step.share * (last - first)
        progress(WorkStep(step.name, share, step.number))

    return say
