"""Proofs of critical points: bounds as numbers with ±, and the text for the terminal, by ``words/certificates.j2``."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_CEILING, Context, Decimal
from typing import TYPE_CHECKING

from vireport.scenario.parameters import Parameter
from vireport.text.formatting import ABSENT

if TYPE_CHECKING:
    from vireport.checks.certificates import Certificate, Enclosure

LONG = Context(prec=200)
"""Arithmetic on bounds that rounds nothing away."""


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


def certify_text(certificates: Sequence[Certificate], parameter: Parameter) -> str:
    """One line for each critical point, and a summary; for the terminal.

    Parameters
    ----------
    certificates : sequence of Certificate
        From `vireport.checks.certify`.
    parameter : Parameter
        The one that is swept.
    """
    from vireport.wording.templates import Words

    say = Words("certificates")
    if not certificates:
        return say("nothing")
    swept = parameter
    kind = max(len(certificate.kind.words) for certificate in certificates)
    label = max(len(certificate.label) for certificate in certificates)
    lines = []
    for certificate in certificates:
        name = f"{certificate.label:<{label}}  {certificate.kind.words:<{kind}}"
        if not certificate.proved:
            lines.append(f"{name}  {say('unproved', certificate)}")
            continue
        value = f"{swept.symbol} = {swept.with_unit(f'({plus_minus(certificate.sweep_value)})')}"
        lines.append(f"{name}  {value}  {say('notes', certificate)}")
    return "\n".join([*lines, say("summary", certificates)])
