"""Bounds that enclose a number, as text: a middle and what it may be off by."""

from __future__ import annotations

from decimal import ROUND_CEILING, Context, Decimal

from vireport.text.formatting import ABSENT

LONG = Context(prec=200)
"""Arithmetic on bounds that rounds nothing away."""


def plus_minus(bounds: tuple[str, str] | None) -> str:
    """Print decimal bounds as a middle and what it may be off by, rounded up.

    Examples
    --------
    >>> plus_minus(("0.6294571410", "0.6294571412")), plus_minus(("0.5", "0.5")), plus_minus(("1.23", "1.26"))
    ('0.6294571411 ± 1e-10', '0.5', '1.24 ± 0.02')
    """
    if bounds is None:
        return ABSENT
    below, above = Decimal(bounds[0]), Decimal(bounds[1])
    if below == above:
        return bounds[0].lower()
    unit = Decimal(1).scaleb(min(int(below.as_tuple().exponent), int(above.as_tuple().exponent)))
    middle = LONG.divide(LONG.add(below, above), Decimal(2)).quantize(unit, context=LONG)
    off = max(LONG.subtract(above, middle), LONG.subtract(middle, below))
    return f"{middle} ± {off.quantize(Decimal(1).scaleb(off.adjusted()), ROUND_CEILING)}".lower()
