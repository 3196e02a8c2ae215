"""What an addition brings to a study: the one record by which plan, verdict, results and report know it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

from vireport.base.progress import Progress

if TYPE_CHECKING:
    from vireport.design.switched_on import SwitchedOn
    from vireport.scenario.blocks import Scenario
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.opening import FactPlace, Statement
    from vireport.study.judging.requirements import Requirement
    from vireport.study.judging.verdict import AddedAnswer, Verdict
    from vireport.study.plan import DeclaredStep
    from vireport.study.result_records import AddedBlocks, DisturbancesData
    from vireport.study.study import Study
    from vireport.text.alerts import AlertCode, Sentence
    from vireport.text.patterns import Phrase

Result = TypeVar("Result")


class AddedQuantity(NamedTuple):
    """A number of an addition that comparisons of scenarios and results know.

    Attributes
    ----------
    name : str
        Macro of its words, in the file that has the name of the addition.
    value : float or None
    unit : str
    bound : float
        Bound of the error of the value.
    note : str
        Why there is no value.
    """

    name: str
    value: float | None
    unit: str
    bound: float = 0.0
    note: str = ""


class AddedFinding(Generic[Result]):
    """What an addition finds out about the device of a scenario, and what follows from it.

    Its one object, `FINDING`, is in the module `finding` of the addition's package. Every plan of a run imports that
    module, so that its methods import what they need. Methods that an addition does not need keep their defaults.

    Attributes
    ----------
    name : str
        Name of its row in `base.additions`, also its key in results.json and in `Study.findings`.
    section : str
        The template of its section in a report, "" where it has none.
    within : str
        The section of the core, or of another addition, that its section belongs to; "" for a separate section.
    extends : str
        The block of the core in results.json to which it adds keys; "" for none.
    files : tuple of str
        The files that it may write beside results.json.
    """

    name: ClassVar[str]
    section: ClassVar[str] = ""
    within: ClassVar[str] = ""
    extends: ClassVar[str] = ""
    files: ClassVar[tuple[str, ...]] = ()

    def steps(self) -> Iterable[DeclaredStep]:
        """The steps of a plan that it declares; `find` is called where any of them runs."""
        raise NotImplementedError

    def refuse_undecidable(self, scenario: Scenario) -> None:
        """Refuse a requirement of a scenario that a run cannot judge, before anything is computed.

        Raises
        ------
        UsageError
        """

    def switched_on(self, study: Study, say: Progress) -> tuple[SwitchedOn, Result] | None:
        """What the device does when it is switched on as the keys of the addition say, and the findings from that.

        It replaces the behaviour under a force that sets in at once. None where no key says how to switch on.
        """
        return None

    def find(self, study: Study, say: Progress) -> Result | None:
        """The findings about a study, whose core is complete but for the neglected effects; None for no finding.

        What `switched_on` found is among the findings of the study already.
        """
        raise NotImplementedError

    def contradicts_rigid_impacts(self, result: Result) -> bool:
        """Whether the motion must be solved with the real stiffness of the membranes, however short its contacts."""
        return False

    def results(self, result: Result | None, study: Study) -> AddedBlocks:
        """Keys of results.json that the addition brings."""
        return {}

    def results_within(self, block: DisturbancesData, result: Result | None) -> DisturbancesData:
        """The block of results.json that the addition extends, with its keys put in."""
        return block

    def compared(self, blocks: Mapping[str, Any]) -> Iterable[AddedQuantity]:
        """Quantities that comparisons use, from the plain data of results.json by the keys of additions."""
        return ()

    def requirements(self) -> Iterable[Requirement]:
        """The requirements that it brings: a row for each of its keys in the block `requirements`."""
        return ()

    def share_of_starts(self, result: Result, evidence: Evidence) -> Phrase | None:
        """A phrase on the share of starts that come to a motion of a required word; None where it is unknown."""
        return None

    def answers(self, result: Result, evidence: Evidence) -> Iterable[AddedAnswer[object]]:
        """Its answers to questions of the verdict, as far as these arise."""
        return ()

    def facts(self, verdict: Verdict) -> Mapping[FactPlace, Iterable[Statement]]:
        """Statements for the opening of a report on its answers, or on their lack, by their place among the facts."""
        return {}

    def causes(self, result: Result, evidence: Evidence) -> Mapping[AlertCode, Iterable[Sentence]]:
        """Sentences on causes of alerts, by the codes of the alerts."""
        return {}

    def pictures(self, result: Result, study: Study, templates: Path | None) -> Iterable[Any]:
        """The figures of its steps that run, each a `figures.style.Picture`."""
        return ()

    def parts(self, result: Result, templates: Path | None) -> Mapping[str, object]:
        """Sentences and tables of its section, by their names in the template."""
        return {}

    def printed(self, result: Result, study: Study) -> str:
        """The text that a run prints about it on standard output."""
        return ""

    def written(self, result: Result, study: Study) -> Mapping[str, bytes]:
        """The contents of files that it writes, by their names."""
        return {}
