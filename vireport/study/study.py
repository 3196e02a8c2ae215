"""Everything that is found out about one scenario, gathered step by step as its plan says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

from msgspec import UNSET, Struct
from msgspec.structs import replace

from vireport.base.errors import Mistake, ScenarioError, UsageError
from vireport.base.progress import Progress, portion
from vireport.base.records import plain
from vireport.design.effects import Effect, Shift, Shifts, Unmoved, shift_to, shifts
from vireport.design.point import with_distortions
from vireport.design.solution import Solution, solution_of, with_tolerances
from vireport.motions.periodicity import model_of
from vireport.motions.sweep import NO_TOLERANCE, Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS
from vireport.physics.word import Word
from vireport.scenario.blocks import LeftOut, MotionsBlock, Scenario, to_dict
from vireport.scenario.loading import Loaded, Source, load
from vireport.scenario.parameters import DesignInput
from vireport.study.families import families_data, motions_data
from vireport.study.judging.alerts import LONG_CONTACT, Alert, alerts
from vireport.study.judging.evidence import Criterion, Evidence, unmet_criteria
from vireport.study.judging.findings import findings, with_results
from vireport.study.judging.least_margin import LimitedBy, margin_to_use
from vireport.study.plan import (
    FORMATS,
    Plan,
    Task,
    motion_limits,
    plan,
    refuse_undecidable,
)
from vireport.study.provenance import Provenance
from vireport.study.result_records import (
    AddedBlocks,
    DisturbancesData,
    LeftOutData,
    MarginToUseData,
    MotionRow,
    RequirementsData,
    Results,
    blocks_of,
)
from vireport.study.results import (
    analytic_results,
    effects_data,
    family_motions,
    json_bytes,
    motion_rows,
    on_bottom_data,
    own_stiffness_data,
    simulation_data,
    switched_on_data,
)
from vireport.text.foreign import visible
from vireport.text.formatting import rounded_text

GUESSES = 16
"""Values of a sweep at which motions with one impact are guessed at, where the force on a table has harmonics."""

if TYPE_CHECKING:
    from vireport.design.attractors_from_rest import AttractorFromRest
    from vireport.design.compliant.own_stiffness import OwnStiffness
    from vireport.design.switched_on import SwitchedOn
    from vireport.motions.families import Atlas
    from vireport.motions.points import Point
    from vireport.simulation.following import Jump
    from vireport.study.checks.crosscheck import CrossCheck
    from vireport.study.checks.reproduction import Reproduction
    from vireport.study.coexistence import Coexisting
    from vireport.study.judging.opening import Opening
    from vireport.study.judging.verdict import Verdict
    from vireport.study.measured import Branching, MeasuredAt


class Study(Struct, frozen=True, eq=False, dict=True):
    """All results of one scenario; what its plan leaves out is None or empty.

    Attributes
    ----------
    loaded : Loaded
        The scenario and where it came from.
    plan : Plan
        The steps of the run, and why others are left out.
    solution : Solution
        Results of the analytic theory: motions, critical points, stable ranges and the design point.
    crosscheck : CrossCheck or None
        Results of the simulation; None without a `simulation:` block.
    attractors_from_rest : tuple of AttractorFromRest
        What a ball from rest comes to at values along the sweep, where figures or families need it.
    atlas : Atlas or None
        The families of motions of other impact sequences.
    own_stiffness : OwnStiffness or None
        The motion and its margin with the membranes' own stiffness; None where contacts are short.
    criteria : tuple of Criterion
        What the scenario requires, and whether it is met; () where nothing is required.
    switched_on : SwitchedOn or None
        What the device does when it is switched on, and how fast small disturbances die out.
    effects : Shifts or None
        How far neglected effects would move the nearest end of stable motion.
    measured : tuple of MeasuredAt
        Motions shown by records of measured impacts; () without records.
    findings : mapping of str to object
        Results of each addition to the study by its name, which is also an attribute of the study.
    """

    loaded: Loaded
    plan: Plan
    solution: Solution
    crosscheck: CrossCheck | None = None
    attractors_from_rest: tuple[AttractorFromRest, ...] = ()
    atlas: Atlas | None = None
    own_stiffness: OwnStiffness | None = None
    criteria: tuple[Criterion, ...] = ()
    switched_on: SwitchedOn | None = None
    effects: Shifts | None = None
    measured: tuple[MeasuredAt, ...] = ()
    findings: Mapping[str, Any] = {}

    if not TYPE_CHECKING:  # so that a checker of types takes no name for any attribute

        def __getattr__(self, name: str) -> Any:
            """Results of the addition of that name; None where it was not asked for."""
            if name in findings():
                return self.findings.get(name)
            raise AttributeError(f"a Study has no attribute {name!r}")

    @property
    def scenario(self) -> Scenario:
        """The scenario as understood, with defaults filled in."""
        return self.loaded.scenario

    @cached_property
    def evidence(self) -> Evidence:
        """The results by which alerts, requirements and the verdict judge the scenario."""
        return Evidence(
            self.solution,
            crosscheck=self.crosscheck,
            atlas=self.atlas,
            own_stiffness=self.own_stiffness,
            criteria=self.criteria,
            switched_on=self.switched_on,
            effects=self.effects,
            findings=self.findings,
        )

    @cached_property
    def alerts(self) -> tuple[Alert, ...]:
        """The alerts, gravest first: what must be known before acting on the numbers."""
        return alerts(self.evidence)

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict as data: the conclusion, and an answer with its status to each question."""
        from vireport.study.judging.verdict import verdict_of

        return verdict_of(self.evidence)

    @property
    def _margin_to_use(self) -> MarginToUseData | None:
        use, on_bottom = margin_to_use(self.evidence), self.evidence.ends_on_bottom
        if on_bottom:
            end = on_bottom[0]
            return MarginToUseData(
                parameter=end.varied,
                relative=end.size,
                limited_by=LimitedBy.RIGID,
                effect=None,
                change=None,
                gone=False,
            )
        return None if use is None else use.data

    @cached_property
    def opening(self) -> Opening:
        """What a report opens with: one sentence, the gravest facts, and the numbers to act on."""
        from vireport.study.judging.opening import opening_of

        return opening_of(self.verdict, self.alerts, self.reproduction)

    @property
    def answer(self) -> str:
        """Whether the device runs, in the sentence that a report opens with."""
        return self.opening.worded().sentence

    @cached_property
    def coexisting(self) -> tuple[Coexisting, ...]:
        """The motions found along a slow sweep, with their ranges; () without one."""
        from vireport.study.coexistence import coexisting

        return coexisting(self.crosscheck, self.atlas) if self.crosscheck is not None else ()

    def ending(self, jump: Jump) -> Point | None:
        """The critical point at which the motion before a jump ends; None if none is known within two steps."""
        from vireport.study.coexistence import ends_at

        check = self.crosscheck
        return ends_at(jump, self.atlas, check.step) if check is not None and self.atlas is not None else None

    @cached_property
    def measured_hysteresis(self) -> tuple[Branching, ...]:
        """Values of the swept input at which the measured motion depended on the direction; () without records."""
        if not self.measured:
            return ()
        from vireport.study.measured import hysteresis

        return hysteresis(self.measured)

    @cached_property
    def reproduction(self) -> Reproduction | None:
        """Comparison of the stable motion with a short simulation; None without such a motion, or without a page."""
        if not self.plan.runs(Task.REPRODUCTION):
            return None
        from vireport.study.checks.reproduction import reproduce

        return reproduce(self.solution)

    def results(self, printed: bool = False) -> Results:
        """Give the results as records, those of results.json without its provenance.

        Parameters
        ----------
        printed : bool
            Whether to include only the families that pages show, `Atlas.printed_families`.
        """
        solution, scenario = self.solution, self.scenario
        results = replace(
            analytic_results(solution, to_dict(scenario), self.plan.reason(Task.DISTORTION)),
            overrides=list(self.loaded.overrides),
            simulation=None
            if self.crosscheck is None
            else simulation_data(self.crosscheck, self.coexisting, self.ending),
            motions=None if self.atlas is None else motions_data(self.atlas),
            families=None
            if self.atlas is None
            else families_data(self.atlas.printed_families if printed else self.atlas.families, solution.membrane),
            own_stiffness=None if self.own_stiffness is None else own_stiffness_data(self.own_stiffness),
            effects=None if self.effects is None else effects_data(self.effects),
            margin_to_use=self._margin_to_use,
            on_bottom=on_bottom_data(self.evidence.bottom) if self.evidence.bottom else UNSET,
            added=self._added_data(),
            requirements=None if scenario.requirements is None else _requirements_data(self.criteria),
            disturbances=None if self.switched_on is None else self._switched_on_data(self.switched_on),
            alerts=[alert.data for alert in self.alerts],
            left_out=[LeftOutData(step=step.task, what=step.what, why=step.why) for step in self.plan.left_out],
        )
        if not self.measured:
            return results
        from vireport.study.measured import measured_data, measured_loops

        return replace(
            results, measured=measured_data(self.measured), measured_hysteresis=measured_loops(self.measured)
        )

    def to_dict(self, printed: bool = False) -> dict[str, Any]:
        """Give results.json as plain data, without its provenance; `printed` is that of `results`."""
        data: dict[str, Any] = plain(blocks_of(self.results(printed)))
        return data

    def _switched_on_data(self, switched: SwitchedOn) -> DisturbancesData:
        """What the device does when it is switched on, with what additions know of it."""
        block = switched_on_data(switched)
        for name, finding in findings().items():
            if finding.extends == "disturbances":
                block = finding.results_within(block, self.findings.get(name))
        return block

    def _added_data(self) -> AddedBlocks:
        """What additions to the study have in results.json."""
        added = (finding.results(self.findings.get(name), self) for name, finding in findings().items())
        return {key: data for block in added for key, data in block.items()}

    def rows(self) -> list[MotionRow]:
        """Give the rows of branches.csv, for a data frame: every motion of the branches, every impact of the families.

        Without a sweep, the rows are the motions of the design point.
        """
        return [*motion_rows(self.solution), *family_motions(self.atlas, self.solution.membrane)]

    def __repr__(self) -> str:
        return f"<Study of {visible(self.loaded.document.name)}: {self.verdict.word}>"

    def _repr_html_(self) -> str:
        """The verdict and the critical points, for a notebook."""
        from html import escape  # only here: it reads the names of all characters

        from vireport.text.tables import html_table

        title = escape(self.scenario.title or self.loaded.document.name)
        opening = self.opening.worded()
        said = "".join(f"<li>{escape(text)}</li>" for _, text in opening.facts)
        numbers = [(tile.label, tile.value, tile.remark) for tile in opening.tiles]
        tiles = html_table(("", "", ""), numbers)
        lead = f"<p><strong>{title}. {escape(opening.sentence)}</strong></p><ul>{said}</ul>{tiles}"
        points, swept = self.solution.critical_points, self.solution.parameter
        if not points:
            return lead
        rows = [
            (
                critical.label,
                critical.event.words,
                critical.symmetry,
                rounded_text(critical.sweep_value, self.evidence.exactness),
                rounded_text(critical.d, self.evidence.exactness),
            )
            for critical in points
        ]
        return f"{lead}\n{html_table(('Point', 'Kind', 'Motion', f'{swept.symbol} [{swept.unit}]', 'd'), rows)}"


def require_study(value: object) -> None:
    """Refuse what is no study, where one is needed."""
    if not isinstance(value, Study):
        raise UsageError(f"a Study is needed, not a value of type {type(value).__name__} (allowed: what analyse gives)")


def results(study: Study, provenance: Provenance, printed: bool = False) -> dict[str, Any]:
    """Give the results of a study as plain data, ready for JSON, with their provenance.

    Parameters
    ----------
    study : Study
        From `analyse`.
    provenance : Provenance
        What made the results.
    printed : bool
        Whether to include only the families that pages show.

    Returns
    -------
    dict
        Content of results.json.

    Raises
    ------
    UsageError
        If `study` is not a Study.
    """
    require_study(study)
    return {**study.to_dict(printed), "provenance": plain(provenance)}


def results_json(study: Study, provenance: Provenance) -> bytes:
    """The text of results.json, from the records of `Study.results`."""
    return json_bytes(blocks_of(study.results()), provenance)


def _requirements_data(criteria: tuple[Criterion, ...]) -> RequirementsData:
    return RequirementsData(passed=not unmet_criteria(criteria), criteria=[criterion.data for criterion in criteria])


def sweep_of(scenario: Scenario) -> Sweep | None:
    """The sweep of a scenario, None where it has none."""
    block, tolerances = scenario.sweep, scenario.tolerances
    if block is None:
        return None
    off = tolerances.off(DesignInput(block.parameter)) if tolerances is not None else NO_TOLERANCE
    return Sweep(Device.of(scenario), block.parameter, block.from_, block.to, off)


def analyse(source: Loaded | Source, formats: Iterable[str] = FORMATS, progress: Progress | None = None) -> Study:
    """Solve a scenario: its motions, their stability and voltages, critical points, margins, and its simulation.

    Parameters
    ----------
    source : Loaded, str, Path or mapping
        Result of `load`, or its input: the path of a file, or the scenario as a mapping.
    formats : iterable of str
        Formats that are to be written, such as ``("json",)``: steps that none of them needs are left out.
    progress : callable, optional
        Called with the name of each long step as it begins.

    Returns
    -------
    Study
        All results.

    Raises
    ------
    UsageError, ScenarioError
        If the file cannot be read, or the scenario in it cannot be used.
    NumericalError
        If the scenario is outside the theory, such as a restitution of 1, or an iteration does not converge.
    """
    if isinstance(source, Study):
        raise UsageError("this Study is solved already (use it as it is; analyse(study.loaded) solves it again)")
    loaded = source if isinstance(source, Loaded) else load(source)
    scenario, steps = loaded.scenario, plan(loaded.scenario, formats)
    refuse_undecidable(scenario)
    say = progress or (lambda what: None)
    measured = _measured(loaded, say) if steps.runs(Task.MEASURED) else ()
    device, tolerances = Device.of(scenario), scenario.tolerances
    at_design = steps.runs(Task.DESIGN)
    say("solving for the 1:1 motions")
    solution = solution_of(device, Membrane.of(scenario), sweep_of(scenario), at_design)
    if solution.design is not None and steps.runs(Task.DISTORTION):
        solution = replace(solution, design=with_distortions(device, solution.design))
    if tolerances is not None:
        solution = with_tolerances(solution, tolerances)
    study = Study(loaded, steps, solution, measured=measured)
    if scenario.simulation is not None:
        from vireport.study.checks.crosscheck import crosscheck

        study = replace(study, crosscheck=crosscheck(solution, scenario.simulation, say))
    if solution.sweep is not None and steps.runs(Task.CIRCLES):
        from vireport.design.attractors_from_rest import attractors_from_rest

        study = replace(study, attractors_from_rest=attractors_from_rest(solution.sweep))
    study = _switched_on(study, say)
    limits = motion_limits(scenario)
    if limits is not None and steps.runs(Task.MOTIONS):
        study = _with_motions(study, limits, say)
    study = _with_findings(study, say)
    if steps.runs(Task.OWN_STIFFNESS):
        say("solving with the membranes' own stiffness")
        study = _with_own_stiffness(study)
    if steps.runs(Task.EFFECTS):
        say("moving the nearest end by what the model leaves out")
        study = _with_effects(study)
    if scenario.requirements is not None:
        from vireport.study.judging.requirements import assess

        say("judging the requirements")
        study = replace(study, criteria=assess(loaded, study.evidence))
    return study


def _with_findings(study: Study, say: Progress) -> Study:
    """Add what additions find out, each where any of its steps runs, and with an equal part of the progress.

    An addition knows what those before it have found.
    """
    running = [
        (name, finding)
        for name, finding in findings().items()
        if study.plan.runs(*(step.task for step in finding.steps()))
    ]
    for k, (name, finding) in enumerate(running):
        new = finding.find(study, portion(say, k / len(running), (k + 1) / len(running)))
        study = study if new is None else replace(study, findings={**study.findings, name: new})
    return study


def _measured(loaded: Loaded, say: Progress) -> tuple[MeasuredAt, ...]:
    from vireport.study.measured import measured_of

    return measured_of(loaded, say)


def _switched_on(study: Study, say: Progress) -> Study:
    """Switch the device on: as an addition says or, as far as the plan has it, at once."""
    for name, finding in findings().items():
        if (switched := finding.switched_on(study, say)) is not None:
            switched_on, new = switched
            return replace(study, switched_on=switched_on, findings={**study.findings, name: new})
    nowhere_stable = study.plan.runs(Task.SAMPLED_FROM_REST) and not study.solution.stable_ranges
    if not (nowhere_stable or study.plan.runs(Task.FROM_REST)):
        return study
    from vireport.design.switched_on import switched_on_at_once

    say("following the ball from rest")
    return replace(study, switched_on=switched_on_at_once(study.solution))


def _with_motions(study: Study, block: MotionsBlock, say: Progress) -> Study:
    from vireport.motions.atlas.families import atlas
    from vireport.motions.atlas.guesses import motions_of

    sweep = study.solution.sweep
    if sweep is None:
        return study
    starts = []
    for row in block.starts:
        word, coordinate = Word.of(row.word, row.periods), float(sweep.coordinate_of(row.value))
        low, high = map(float, sweep.coordinate_range)
        starts.append(motions_of(word, model_of(sweep, ARRAYS), low, high, coordinate))
    limits = Limits(block.impacts, block.periods)
    guesses = chain(_on_table(study.solution, sweep), _simulated(study, sweep))
    families = atlas(sweep, limits, chain(chain.from_iterable(starts), guesses), say)
    _require_motions(study.loaded, block, starts, families)
    return replace(study, atlas=families)


def _on_table(solution: Solution, sweep: Sweep) -> Iterator[Motion]:
    """Guesses at motions with one impact on a table whose force has harmonics: those of the sine at some values.

    Of a sine all are found in closed form.
    """
    from vireport.motions.atlas.one_impact import stable_on_table

    if not (solution.on_table and sweep.device.harmonics):
        return
    for k in range(GUESSES):
        value = sweep.start + (k + 0.5) / GUESSES * (sweep.end - sweep.start)
        for motion in stable_on_table(sweep.device.groups(sweep.parameter, value).as_floats()):
            yield replace(motion, coordinate=float(sweep.coordinate_of(value)))


def _simulated(study: Study, sweep: Sweep) -> Iterator[Motion]:
    """The motions that the simulation comes to along a sweep, and at the design point: from rest and from starts."""
    check, switched_on, design = study.crosscheck, study.switched_on, study.solution.design
    if check is not None:
        ends = [(value, end.cycle) for value, end in check.attractors()]
    else:
        ends = [(settled.value, settled.motion) for settled in study.attractors_from_rest]
    if switched_on is not None and switched_on.from_rest is not None and design is not None:
        ends.append((design.value, switched_on.from_rest.cycle))
    for value, cycle in ends:
        if cycle is not None and not cycle.sticks:
            yield cycle.motion(float(sweep.coordinate_of(value)))
    if switched_on is not None and design is not None:
        for followed in switched_on.by_starts:
            yield replace(followed.motion, coordinate=float(sweep.coordinate_of(design.value)))


def _require_motions(loaded: Loaded, block: MotionsBlock, motions: Sequence[Sequence[Motion]], families: Atlas) -> None:
    """Refuse words that no motion was found of at their value, with those that there are.

    Raises
    ------
    ScenarioError
    """
    mistakes = []
    for k, (row, by_row) in enumerate(zip(block.starts, motions, strict=True)):
        word, parameter, path = Word.of(row.word, row.periods), families.sweep.parameter, f"motions.starts.{k}"
        words = {motion.word.canonical() for _, motion in families.at(row.value)}
        if not by_row and word.canonical() not in words:
            names = [
                stable_word.name
                for stable_word in sorted(
                    words, key=lambda stable_word: (stable_word.periods, len(stable_word), stable_word.letters)
                )
            ]
            what = f"no motion {word.name} was found at {parameter.place(row.value)}"
            mistakes.append(Mistake(loaded.line_of(path) or 0, path, f"{what} (there: {', '.join(names) or 'none'})"))
    if mistakes:
        raise ScenarioError(loaded.document.name, mistakes)


def _with_own_stiffness(study: Study) -> Study:
    """Add the motion with the membranes' own stiffness where contacts are long, or found to matter, for rigid ones."""
    share = study.evidence.contact_share
    contradicted = any(finding.contradicts_rigid_impacts(result) for finding, result in with_results(study.findings))
    if share is None or not (share > LONG_CONTACT or contradicted):
        return study
    from vireport.design.compliant.own_stiffness import own_stiffness

    return replace(study, own_stiffness=own_stiffness(study.solution))


def _with_effects(study: Study) -> Study:
    """Add how far the nearest end would move, by the membranes' own stiffness as well where that is known."""
    design, compliant = study.solution.design, study.own_stiffness
    if design is None:
        return study
    required = study.scenario.requirements
    required_margin = required is not None and required.margin_with_effects_percent is not None
    moved = shifts(study.solution.device, design, Effect.requested(study.scenario.effects), required_margin)
    at = (
        compliant.end_of(moved.end.parameter, moved.end.point)
        if compliant is not None and moved.end is not None
        else None
    )
    if compliant is None or at is None or moved.end is None:
        return replace(study, effects=moved)
    effect, end = Effect(LeftOut.STIFFNESS), moved.end
    if at.compliant is not None:
        value = float(study.solution.device.value_of(end.parameter))
        moved = replace(moved, rows=(*moved.rows, shift_to(effect, end, at.compliant, end.event, value)))
    elif compliant.margin_gone:
        moved = replace(moved, rows=(*moved.rows, Shift(effect, absence=Unmoved.NOT_STABLE)))
    return replace(study, effects=moved)
