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
        Macro of its words, in the file that is named as the addition.
    value : float or None
    unit : str
    bound : float
        Of its error.
    note : str
        Why there is none.
    """

    name: str
    value: float | None
    unit: str
    bound: float = 0.0
    note: str = ""


class AddedFinding(Generic[Result]):
    """What an addition finds out about the device of a scenario, and what follows from it.

    Its one object, `FINDING`, stands in the module `finding` of the addition's package, which every plan of a run
    reads: methods import what they need. What an addition does not bring, it leaves as it is here.

    Attributes
    ----------
    name : str
        Of its row in `base.additions`: also its key in results.json and in `Study.findings`.
    section : str
        The template of its section in a report, "" where it has none.
    within : str
        The section of the core, or of another addition, that this one belongs to; "" where it is one of its own.
    extends : str
        The block of results.json that the core has and that gets keys of its own; "" where none does.
    files : tuple of str
        The files that it may write with results.json.
    """

    name: ClassVar[str]
    section: ClassVar[str] = ""
    within: ClassVar[str] = ""
    extends: ClassVar[str] = ""
    files: ClassVar[tuple[str, ...]] = ()

    def steps(self) -> Iterable[DeclaredStep]:
        """Rows of the plan; where any of them runs, the addition is looked for."""
        raise NotImplementedError

    def refuse_undecidable(self, scenario: Scenario) -> None:
        """Refuse what a scenario requires of it and a run cannot judge, before anything is computed.

        Raises
        ------
        UsageError
        """

    def switched_on(self, study: Study, say: Progress) -> tuple[SwitchedOn, Result] | None:
        """What the device does when it is switched on as its keys say, and what it finds out by that.

        It takes the place of what a device does to which the whole force sets in at once. None where no key says how.
        """
        return None

    def find(self, study: Study, say: Progress) -> Result | None:
        """What it finds out about a study that has all of the core but what the model leaves out; None for nothing.

        What it found by switching the device on is among what the study has found.
        """
        raise NotImplementedError

    def contradicts_rigid_impacts(self, result: Result) -> bool:
        """Whether the motion is to be solved with the membranes' own stiffness, short as its contacts may be."""
        return False

    def results(self, result: Result | None, study: Study) -> AddedBlocks:
        """Keys of results.json that the addition brings."""
        return {}

    def results_within(self, block: DisturbancesData, result: Result | None) -> DisturbancesData:
        """The block of results.json that it extends, with its keys in their places there."""
        return block

    def compared(self, blocks: Mapping[str, Any]) -> Iterable[AddedQuantity]:
        """What comparisons know of the plain data that results have of additions, by their keys."""
        return ()

    def requirements(self) -> Iterable[Requirement]:
        """What can be required of it: a row for each of its keys in the block `requirements`."""
        return ()

    def share_of_starts(self, result: Result, evidence: Evidence) -> Phrase | None:
        """How many starts come to a motion of a word that is required, in words; None where it does not know."""
        return None

    def answers(self, result: Result, evidence: Evidence) -> Iterable[AddedAnswer[object]]:
        """The answers of the verdict to its questions, as far as they arise."""
        return ()

    def facts(self, verdict: Verdict) -> Mapping[FactPlace, Iterable[Statement]]:
        """What a report opens with of its answers, or of their lack, by the place among the facts of the core."""
        return {}

    def causes(self, result: Result, evidence: Evidence) -> Mapping[AlertCode, Iterable[Sentence]]:
        """What raises alerts, by their codes."""
        return {}

    def pictures(self, result: Result, study: Study, templates: Path | None) -> Iterable[Any]:
        """The figures among its steps, each a `figures.style.Picture`."""
        return ()

    def parts(self, result: Result, templates: Path | None) -> Mapping[str, object]:
        """Sentences and tables of its section, by the names that its template knows."""
        return {}

    def printed(self, result: Result, study: Study) -> str:
        """What a run prints of it on standard output."""
        return ""

    def written(self, result: Result, study: Study) -> Mapping[str, bytes]:
        """The content of its files, as far as there is any."""
        return {}
