"""Proofs of critical points as text for the terminal, by ``words/certificates.j2``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vireport.scenario.parameters import Parameter
from vireport.text.enclosed import plus_minus

if TYPE_CHECKING:
    from vireport.findings.certificates.results import Certificate


def certify_text(certificates: Sequence[Certificate], parameter: Parameter) -> str:
    """One line for each critical point, and a summary; for the terminal.

    Parameters
    ----------
    certificates : sequence of Certificate
    parameter : Parameter
        The one that is swept.
    """
    from vireport.text.templates import Words

    say = Words("certificates")
    if not certificates:
        return say("nothing")
    kind = max(len(certificate.kind.words) for certificate in certificates)
    label = max(len(certificate.label) for certificate in certificates)
    lines = []
    for certificate in certificates:
        name = f"{certificate.label:<{label}}  {certificate.kind.words:<{kind}}"
        if not certificate.proved:
            lines.append(f"{name}  {say('unproved', certificate)}")
            continue
        value = f"{parameter.symbol} = {parameter.with_unit(f'({plus_minus(certificate.sweep_value)})')}"
        lines.append(f"{name}  {value}  {say('notes', certificate)}")
    return "\n".join([*lines, say("summary", certificates)])
