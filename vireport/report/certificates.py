"""Proofs of critical points in words: a bound as a number with ±, a summary, and the text for the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_CEILING, Context, Decimal
from typing import TYPE_CHECKING

from vireport.scenario import Parameter
from vireport.text import ABSENT

if TYPE_CHECKING:
    from vireport.checks.certificates import Certificate, Enclosure

LONG = Context(prec=200)
"""Arithmetic on bounds that rounds nothing away."""

BETWEEN = {True: "yes, proved", False: "no, proved", None: "undecided"}
"""Whether the ball stays between the membranes."""


def plus_minus(bounds: Enclosure | None) -> str:
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


def summary(certificates: Sequence[Certificate]) -> str:
    """How many points are proved, and whether their stated error bounds hold, in a sentence or two."""
    proved = [certificate for certificate in certificates if certificate.proved]
    beyond = [certificate.label for certificate in proved if not certificate.bound_holds]
    unmirrored = [certificate.label for certificate in proved if certificate.mirror_proved is False]
    text = f"{len(proved)} of {len(certificates)} critical point{'s' * (len(certificates) != 1)} proved"
    if proved and not beyond:
        text += ", each within the error bound that is stated for it"
    elif beyond:
        text += f", but the error bound stated is not proved to hold for {', '.join(beyond)}"
    if unmirrored:
        text += f"; the mirror image is not proved for {', '.join(unmirrored)}"
    others = [f"{certificate.label} ({', '.join(certificate.beyond)})" for certificate in proved if certificate.beyond]
    if others:
        text += f"; error bounds stated for other numbers are not proved for {', '.join(others)}"
    return f"{text}."


def certify_text(certificates: Sequence[Certificate], parameter: Parameter) -> str:
    """One line for each critical point, and a summary; for the terminal.

    Parameters
    ----------
    certificates : sequence of Certificate
        From `vireport.checks.certificates.certify`.
    parameter : Parameter
        The one that is swept.
    """
    if not certificates:
        return "no critical points to prove"
    swept = parameter
    kind = max(len(certificate.kind.words) for certificate in certificates)
    label = max(len(certificate.label) for certificate in certificates)
    lines = []
    for certificate in certificates:
        name = f"{certificate.label:<{label}}  {certificate.kind.words:<{kind}}"
        if not certificate.proved:
            lines.append(f"{name}  not proved: {certificate.reason}")
            continue
        value = f"{swept.symbol} = {swept.with_unit(f'({plus_minus(certificate.sweep_value)})')}"
        notes = [f"alone within {certificate.radius:.0e}", *([certificate.side] if certificate.side else [])]
        if certificate.admissible is not True:
            notes.append(f"ball between the membranes: {BETWEEN[certificate.admissible]}")
        lines.append(f"{name}  {value}  {', '.join(notes)}")
    return "\n".join([*lines, summary(certificates)])
