"""A line of the acceptance table, and how a number is held against a limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from vireport.errors import NumericalError

LineOf = Callable[[str], int | None]

DIGITS = 6
"""Significant digits of a value; more where it would look like a limit that it is not."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a requirement comes to.

    Attributes
    ----------
    value : float or None
        None where there is none, or what is required is not known.
    text : str
        The value, with its unit, or what there is instead.
    margin : float or None
        How far the value is on the right side of the limit, in the limit's unit; negative on the wrong one.
    passed : bool
    why : str
        Where the value comes from, or what is in the way.
    error_bound : float
        Of the value, and so of the margin.
    """

    value: float | None
    text: str
    margin: float | None
    passed: bool
    why: str
    error_bound: float = 0.0


@dataclass(frozen=True, slots=True)
class Criterion:
    """A line of the acceptance table.

    Attributes
    ----------
    key : str
        Of the scenario; the first where two belong together.
    title : str
    limit : str
        In words, with its unit.
    limit_value : float or None
        None where the requirement has no number. Of a range, its width.
    unit : str
        Of the limit, the value and the margin.
    value : float or None
        None where there is none. Of a range, how much of it is covered.
    value_text : str
    margin : float or None
        How far the value is on the right side of the limit; of a range, how far stable motion goes beyond it.
    passed : bool
    why : str
        Where the value comes from, or why the requirement is not met.
    error_bound : float
        Of the value and the margin; a requirement that it leaves undecided is not met.
    line : int or None
        In the scenario's file; None where the limit was set over the file.
    """

    key: str
    title: str
    limit: str
    limit_value: float | None
    unit: str
    value: float | None
    value_text: str
    margin: float | None
    passed: bool
    why: str
    error_bound: float
    line: int | None

    @property
    def margin_text(self) -> str:
        """The margin with its sign and unit, "" where there is none."""
        if self.margin is None:
            return ""
        digits = max(3, len(f"{abs(self.margin):.0f}")) if abs(self.margin) < 1e6 else 3
        return f"{self.margin:+.{digits}g} {self.unit}".rstrip()


def criterion(
    line_of: LineOf,
    keys: Sequence[str],
    title: str,
    limit: tuple[str, float | None, str],
    judge: Callable[[], Judgement],
) -> Criterion:
    """Judge a requirement; one that cannot be judged is not met.

    Parameters
    ----------
    line_of : callable
        Path of a key -> its line in the scenario's file, None where it is not from there.
    keys : sequence of str
        Of the scenario's block; several where they belong together.
    title : str
    limit : tuple of str, float or None, str
        Its text, number and unit.
    judge : callable
        May raise NumericalError, which then is the reason.
    """
    try:
        x = judge()
    except NumericalError as error:
        x = Judgement(None, "not known", None, False, str(error))
    text, number, unit = limit
    lines = (line_of(f"requirements.{key}") for key in keys)
    line = next((line for line in lines if line is not None), None)
    return Criterion(
        keys[0], title, text, number, unit, x.value, x.text, x.margin, x.passed, x.why, x.error_bound, line
    )


def held(value: float, limit: float, unit: str, least: bool, why: str, bound: float = 0.0) -> Judgement:
    """Hold a number, known to within a bound, against a limit that it must reach or must not exceed."""
    margin = value - limit if least else limit - value
    if margin >= 0 > margin - bound:
        why = f"not decided: known to within {bound:.1g} {unit} only; {why}"
    return Judgement(value, f"{_apart(value, limit)} {unit}", margin, margin - bound >= 0, why, bound)


def _apart(value: float, limit: float) -> str:
    """Print a number with as many digits as it takes to tell it from the limit that it is not."""
    for digits in range(DIGITS, 18):
        text = f"{value:.{digits}g}"
        if value == limit or float(text) != limit:
            return text
    return repr(value)


def unmet(criteria: Sequence[Criterion]) -> str:
    """Name what is not met, without a full stop; "" where all is."""
    failed = [one for one in criteria if not one.passed]
    if not failed:
        return ""
    names = "; ".join(f"{one.title} ({one.limit})" for one in failed)
    return f"{len(failed)} of {len(criteria)} requirements {'is' if len(failed) == 1 else 'are'} not met: {names}"
