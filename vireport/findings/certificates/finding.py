"""What `--certify` brings to a study: proven enclosures of its critical points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from vireport.base.progress import Progress
from vireport.scenario.parameters import Parameter
from vireport.study.finding import AddedFinding
from vireport.study.plan import FLINT, AddedTask, DeclaredStep, Precondition, Task
from vireport.text.enclosed import plus_minus

if TYPE_CHECKING:
    from vireport.findings.certificates.results import Certificate
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study


class CertificatesFinding(AddedFinding["tuple[Certificate, ...]"]):
    """Proofs of the critical points as an addition to a study."""

    name = "certificates"
    section = "sections/certificates.typ.j2"
    within = "appendix"

    def steps(self) -> Iterator[DeclaredStep]:
        """The step that proves critical points, listed where `--certify` asks for it."""
        certify = Precondition(lambda _, formats: self.name in formats, "no proofs are asked for")
        task = AddedTask(self.name, "proofs of the critical points")
        yield DeclaredStep(task, (FLINT,), "asked for", (certify,), before=Task.REQUIREMENTS)

    def find(self, study: Study, say: Progress) -> tuple[Certificate, ...]:
        """Prove the critical points of the sweep."""
        from vireport.findings.certificates.proofs import certify

        say("proving the critical points")
        return certify(study.solution.diagram)

    def results(self, certificates: tuple[Certificate, ...] | None, study: Study) -> AddedBlocks:
        """The block `certificates` of results.json."""
        return {self.name: certificates}

    def printed(self, certificates: tuple[Certificate, ...], study: Study) -> str:
        """A line on standard output for each critical point."""
        if study.solution.sweep is None:
            return "No critical point to prove: there is no sweep.\n"
        return certify_text(certificates, study.solution.sweep.parameter).rstrip() + "\n"


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


FINDING = CertificatesFinding()
