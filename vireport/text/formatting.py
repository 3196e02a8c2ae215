"""Numbers to text, in one place: the digits that an error leaves, units, rounding.

`rounded_text` decides how many digits of a result are printed, for every page, table, figure and terminal: as many as
its error leaves. What a scenario states is printed as it is stated (`exact`). The bench's page, whose curves follow the
hand before a run does, has its twin (`shown` in templates/bench/elements.js). No results, and left to those who write
them, are counts, times that work takes, ticks, files of data, and what messages that refuse an input quote of it and
allow: `tests/test_digits.py` has the list.

Nothing here prints 0, 1 or 100 % for a number that is not exactly that. Text made here is plain Unicode with
two marks that the templates know: ``*x*`` is a symbol, ``x_c`` has a subscript.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Decimal
from itertools import pairwise
from math import isclose, isfinite, log10

from msgspec import Struct

MINUS, TIMES = "\u2212", "\u00d7"
ABSENT = "\u2014"
"""Stands for what does not exist."""

MOST_DIGITS = 17
"""Significant digits that tell every double from its neighbours."""

SETTLED = 15
"""Significant digits that rounding errors leave alone: a number that is short in as many is printed short."""

SMALLEST_PLAIN, LARGEST_PLAIN = -5, 6
"""Powers of ten between which numbers are written out."""

PREFIXES = {-9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
"""Prefixes of the units that take one, by powers of ten."""


class Exactness(Struct, frozen=True):
    """How exact numbers are: the largest error of any of them, over its value.

    Examples
    --------
    >>> [Exactness(relative).digits for relative in (0.05, 0.026, 0.005, 0.0049)]
    [2, 3, 3, 4]
    """

    relative: float

    @property
    def digits(self) -> int:
        """Significant digits that may be printed: rounding to them stays within the error, whatever the first is."""
        return max(1, 1 - Decimal(repr(2 * self.relative)).adjusted())


OF_A_MODEL = Exactness(0.01)
"""Of what a model tells whose error is not known, or is common to all that it tells: three digits, so that neighbouring
designs can be told apart."""

ROUGHLY = Exactness(0.05)
"""Of errors, shares and times: two digits."""

OF_INPUTS = Exactness(5e-8)
"""Of inputs: eight digits, more than anyone gives."""

NO_BREAK = "\u00a0"
_TIED = re.compile(
    r" (?=[=<>≤≥±] )|(?<=[=±]) |(?<=×) (?=10)"
    r"|(?<=[\d⁰¹²³⁴⁵⁶⁷⁸⁹]) (?=%|×|[nµmkMG]?(?:m|V|N|g|Hz|s|W|J|rad)(?!\w))"
)
"""Spaces of quantities: before relations, after those that equate, and between numbers and units."""

_SUPERSCRIPT = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


def rounded_text(value: float | None, error: float | Exactness = OF_A_MODEL, power: int = 0) -> str:
    """Print a number with the digits that its error leaves: rounded within the error, where a digit more is noise.

    Parameters
    ----------
    value : float or None
        None is printed as a dash.
    error : float or Exactness
        Of the value, in its unit; or how exact all numbers of a study, or of a table's column, are.
    power : int
        Power of ten that the number is multiplied by, for a column whose unit has a prefix.

    Examples
    --------
    >>> rounded_text(0.62945714101, 3e-6), rounded_text(0.62945714101, Exactness(0.02))
    ('0.629457', '0.629')
    >>> rounded_text(42836.16467, 200, power=-3), rounded_text(0.5, 1e-9), rounded_text(1 - 1e-9, 1e-3)
    ('42.8', '0.5', '0.999999999')
    """
    if value is None or not isfinite(value):
        return ABSENT
    number = _shortest(value)
    return _print(number.scaleb(power), _last(number, error) + power, reserved=1)


def errors_apart(values: Sequence[float], error: float | Exactness = OF_A_MODEL) -> list[float]:
    """Errors with which to show numbers so that those that differ are told apart: no larger than half of what they do.

    Of two numbers of one model the difference is known better than they are. Numbers that agree to 14 digits differ by
    rounding.
    """
    numbers = [_shortest(value) for value in values]
    ordered = sorted({_round(number, SETTLED - 1) for number in numbers})
    gap = min((high - low for low, high in pairwise(ordered)), default=None)
    lasts = (_last(number, error) for number in numbers)
    return [float(Decimal((0, (5,), (last if gap is None else min(last, gap.adjusted())) - 1))) for last in lasts]


def apart(values: Sequence[float], error: float | Exactness = OF_A_MODEL, power: int = 0) -> list[str]:
    """Print numbers as `rounded_text`, with as many more digits as tell how far those that differ are apart.

    Examples
    --------
    >>> apart([3, 5.349243789]), apart([5.482549321, 5.482550456])
    (['3', '5.35'], ['5.482549', '5.482550'])
    """
    return [rounded_text(value, fine, power) for value, fine in zip(values, errors_apart(values, error), strict=True)]


def measured(value: float, standard_error: float) -> str:
    """Print a number with the digits to which its standard error is told: with two of that.

    Examples
    --------
    >>> measured(0.451283, 0.0034), measured(0.451283, 0.0068)
    ('0.4513', '0.4513')
    """
    return rounded_text(value, ROUGHLY.relative * standard_error)


def span(low: float, high: float, error: float | Exactness = OF_A_MODEL, power: int = 0) -> str:
    """Print both ends of a range, in as many more digits as it takes to tell them apart.

    Examples
    --------
    >>> span(3, 5.349243789), span(5.482549321, 5.482550456), span(1.5, 1.5)
    ('3 to 5.35', '5.482549 to 5.482550', '1.5')
    """
    return " to ".join(dict.fromkeys(apart((low, high), error, power)))


def exact(value: float, power: int = 0) -> str:
    """Print the shortest digits that read back as the number, times a power of ten: for what a scenario gives.

    Examples
    --------
    >>> exact(0.1245), exact(408470.0), exact(-3.0), exact(1e-15), exact(0.0041, 3)
    ('0.1245', '408470', '−3', '1 × 10⁻¹⁵', '4.1')
    """
    if value == 0:
        return "0"
    return _layout(_shortest(value).scaleb(power).normalize())


def stated_text(value: float) -> str:
    """Print an input among words or in a figure: as given, but for what a search leaves and nobody can make.

    Examples
    --------
    >>> stated_text(0.1245), stated_text(1.0360754605237377)
    ('0.1245', '1.0360755')
    """
    return rounded_text(value, OF_INPUTS)


def written(value: object) -> str:
    """Print a value of a scenario: numbers as `exact`, a list with commas, a dash for what is not given.

    Examples
    --------
    >>> written([0.5, 2.0]), written(("BT", "BBT")), written(()), written(True), written(None)
    ('0.5, 2', 'BT, BBT', 'none', 'true', '—')
    """
    if value is None:
        return ABSENT
    if isinstance(value, list | tuple):
        return ", ".join(map(written, value)) or "none"
    if isinstance(value, bool):
        return str(value).lower()
    return exact(value) if isinstance(value, float) else str(value)


def error_bound(bound: float) -> str:
    """Round a bound up to two digits, so that what is printed still is one.

    Examples
    --------
    >>> error_bound(5.551115123125783e-17), error_bound(0.0)
    ('5.6 × 10⁻¹⁷', '0')
    """
    if bound == 0:
        return "0"
    number = Decimal(bound)
    unit = Decimal(1).scaleb(number.adjusted() - 1)
    return _layout(number.quantize(unit, ROUND_CEILING).normalize())


def percent(fraction: float | None, error: float | Exactness = ROUGHLY, signed: bool = False) -> str:
    """Print a share in per cent; 0 and 100 only where it is exactly that.

    Examples
    --------
    >>> percent(-0.0922164), percent(0.0739054, signed=True), percent(0.99999), percent(0.0), percent(0.0995)
    ('−9.2 %', '+7.4 %', '99.999 %', '0 %', '10 %')
    """
    if fraction is None or not isfinite(fraction):
        return ABSENT
    number = _shortest(fraction)
    sign = "+" if signed and fraction > 0 else ""
    return f"{sign}{_print(number.scaleb(2), _last(number, error) + 2, reserved=100)} %"


def quantity(value: float | None, unit: str, error: float | Exactness = OF_A_MODEL) -> str:
    """Print a number with its unit, with the prefix that brings it between 1 and 1000.

    Examples
    --------
    >>> quantity(42836.16467, "V"), quantity(0.0192, "m", ROUGHLY), quantity(0.0, "V")
    ('42.8 kV', '19 mm', '0 V')
    """
    if value is None or not isfinite(value):
        return ABSENT
    if value == 0:
        return f"0 {unit}"
    number = _shortest(value)
    rounded = number.quantize(Decimal(1).scaleb(_last(number, error)), ROUND_HALF_EVEN)
    power = 3 * ((rounded or number).adjusted() // 3)
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return f"{rounded_text(value, error, -power)} {PREFIXES[power]}{unit}"


def capital(text: str) -> str:
    """Begin with a capital letter, unless with the path of a key; leave the rest alone.

    Examples
    --------
    >>> capital("stable node"), capital("simulation.diagram is false")
    ('Stable node', 'simulation.diagram is false')
    """
    first = text.partition(" ")[0]
    return text if "_" in first or "." in first[:-1] else text[:1].upper() + text[1:]


def words(text: str) -> str:
    """Set the plain ASCII of our own messages in type: Greek letters, minus signs, powers.

    Examples
    --------
    >>> words("|lambda_i| <= 1 at -0.41 %, to 4.58e+04 V")
    '|λ_i| ≤ 1 at −0.41 %, to 4.58 × 10⁴ V'
    """
    for ascii_name, letter in _GREEK.items():
        text = re.sub(rf"\b{ascii_name}(?=_[a-z]\b|\b)", letter, text)
    text = text.replace("<=", "\u2264").replace(">=", "\u2265").replace("N/m^h", "N/m\u02b0")
    text = re.sub(r"(\d)e([+-]\d+)\b", lambda match: f"{match[1]} {_power(int(match[2]))}", text)
    return re.sub(r"(?<![\w.)])-(?=\d)", MINUS, text)


def tied(text: str) -> str:
    r"""Put no-break spaces into quantities, so that no line ends within one.

    Examples
    --------
    >>> tied("at f = 2 Hz, off by 3 × 10⁻¹³ rad").split(" ")
    ['at', 'f\xa0=\xa02\xa0Hz,', 'off', 'by', '3\xa0×\xa010⁻¹³\xa0rad']
    """
    return _TIED.sub(NO_BREAK, text)


def subtitle(*parts: str) -> str:
    """The line below the heading of a page: its parts, but for empty ones, none of which is broken within a quantity.

    Examples
    --------
    >>> subtitle("Prototype", "", "measured.yaml")
    'Prototype · measured.yaml'
    """
    return " · ".join(tied(part) for part in parts if part)


_GREEK = {
    "lambda": "\u03bb",
    "Delta": "\u0394",
    "delta": "\u03b4",
    "beta": "\u03b2",
    "omega": "\u03c9",
    "gbar": "\u1e21",
}


def _shortest(value: float) -> Decimal:
    """The shortest decimal number that reads back as the double."""
    return Decimal(repr(float(value)))


def _last(number: Decimal, error: float | Exactness) -> int:
    """Power of ten of the last digit that an error leaves of a number: of the first, where it leaves none."""
    first = number.adjusted()
    if isinstance(error, Exactness):
        last = _round(number, error.digits).adjusted() - error.digits + 1
    else:
        last = min(first, _shortest(2 * error).adjusted()) if error > 0 else first - MOST_DIGITS
    return max(last, first - MOST_DIGITS + 1)


def _print(number: Decimal, last: int, reserved: int) -> str:
    """Round to the digit of a power of ten, and finer where that gives 0, or `reserved` for another number."""
    settled = _round(number, SETTLED)
    for power in range(last, number.adjusted() - MOST_DIGITS, -1):
        rounded = number.quantize(Decimal(1).scaleb(power), ROUND_HALF_EVEN)
        if abs(rounded) in (0, reserved) and rounded not in (number, settled):
            continue
        return _layout(rounded.normalize() if rounded in (number, settled) else rounded)
    return _layout(number.normalize())


def _round(number: Decimal, digits: int) -> Decimal:
    """Round half to even to significant digits."""
    if number == 0:
        return Decimal(0)
    last = number.adjusted() - digits + 1
    rounded = number.quantize(Decimal(1).scaleb(last), ROUND_HALF_EVEN)
    # 9.95 in two digits is 10, and not 10.0, which would claim three.
    carried = rounded.adjusted() - number.adjusted()
    return rounded.quantize(Decimal(1).scaleb(last + carried)) if carried else rounded


def _layout(number: Decimal) -> str:
    """Write a decimal number with the digits it has, as a power of ten where plain digits would be many."""
    sign = MINUS if number < 0 else ""
    exponent = number.adjusted()
    if SMALLEST_PLAIN <= exponent <= LARGEST_PLAIN:
        return f"{sign}{abs(number):f}"
    digits = "".join(map(str, number.as_tuple().digits))
    mantissa = digits[0] + (f".{digits[1:]}" if len(digits) > 1 else "")
    return f"{sign}{mantissa} {_power(exponent)}"


def _power(exponent: int) -> str:
    return f"{TIMES} 10{str(exponent).translate(_SUPERSCRIPT)}"


def factor_text(value: float) -> str:
    """A power of ten, or the number."""
    power = round(log10(value))
    if power and isclose(value, 10.0**power, rel_tol=1e-12) and abs(power) > 1:
        return words(f"1e{power:+03d}").removeprefix(f"1 {TIMES} ")
    return rounded_text(value)
