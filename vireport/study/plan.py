"""What a run has to do: derived from the scenario and the outputs asked for, before anything is computed.

A run follows its plan; what the plan leaves out is neither computed, nor imported, nor drawn. One more step is one
more member of `Task` and one more row of `STEPS`; those of additions to a study are declared with these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import StrEnum
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from msgspec import Struct

from vireport.base.additions import ADDITIONS
from vireport.base.errors import NumericalError, UsageError, install_command
from vireport.physics.device import Device
from vireport.physics.reach import is_table
from vireport.scenario.blocks import Direction, MotionsBlock, Scenario
from vireport.scenario.keys import value_at
from vireport.scenario.parameters import Parameter
from vireport.scenario.rules import ADDED_IF_FULL, SPECIAL, Special, barred_blocks
from vireport.study.judging.findings import findings
from vireport.text.formatting import capital


class Task(StrEnum):
    """What a run can do; the value is its name in results.json and on the command line.

    Attributes
    ----------
    what : str
        What it is, for the reader.
    """

    what: str

    def __new__(cls, name: str, what: str = "") -> Task:
        """Make the member whose value is `name`."""
        member = str.__new__(cls, name)
        member._value_, member.what = name, what
        return member

    BRANCHES = "branches", "branches of 1:1 motions along the sweep, admissibility and stability"
    SYMMETRIC = "symmetric", "the symmetric family"
    CRITICAL = "critical", "critical points and Table 1"
    DESIGN = "design", "the motions at the design point and their margins"
    DISTORTION = "distortion", "the least harmonics of the force that end the stable motion"
    EFFECTS = "effects", "how far the nearest end of stable motion would move by what the model leaves out"
    ENERGY = "energy", "voltages"
    CONVERSION = "conversion", "energy per impact, mean power, efficiency and electric field at the design point"
    FROM_REST = "from-rest", "what the device comes to when it is switched on, and how fast disturbances die out"
    SAMPLED_FROM_REST = "from-rest-sampled", "what it comes to at some values of a sweep without stable 1:1 motion"
    REPRODUCTION = "reproduction", "the stable motion, found again by simulation from beside it"
    FIGURE_ANSWER = "figure-answer", "impact speeds over the sweep, on the first page (figure-answer)"
    FIGURE_2 = "figure-2", "impact velocity, phase and flight time (figure-2)"
    FIGURE_4 = "figure-4", "Delta and the eigenvalues (figure-4)"
    FIGURE_7 = "figure-7", "voltages along the sweep (figure-7)"
    CIRCLES = (
        "circles",
        "what a ball from rest comes to along the sweep: circles in figures, starts of families",
    )
    SIMULATION = "simulation", "simulation of the sampled motions"
    MOTIONS = "motions", "families of motions of other impact sequences"
    FIGURE_3 = "figure-3", "phase portraits and time series (figure-3)"
    FIGURE_6 = "figure-6", "displacement of the capsule's ends and of the ball (figure-6)"
    OWN_STIFFNESS = "own-stiffness", "the motion and its margin with the membranes' own stiffness, if contacts are long"
    MEASURED = "measured", "measured impacts, beside what is computed"
    FIGURE_DEVICE = "figure-device", "the device, and the path of the ball at the design point"
    FIGURE_MARGINS = "figure-margins", "what moves the nearest end of stable motion"
    FIGURE_CYCLE = "figure-cycle", "the electrical cycle of each impact at the design point (figure-cycle)"
    FIGURE_DIAGRAM = "figure-diagram", "bifurcation diagram by simulation"
    FIGURE_HYSTERESIS = "figure-hysteresis", "the motions of a slow sweep, with their jumps"
    FIGURE_ATLAS = "figure-atlas", "families of motions of all impact sequences"
    FIGURE_LADDER = "figure-ladder", "voltage and impacts per second of each impact sequence"
    FIGURE_PORTRAITS = "figure-portraits", "paths and phase portraits of chosen motions"
    REQUIREMENTS = "requirements", "the acceptance table"
    OPTIMISE = "optimise", "the best design"
    HTML = "html", "output: report.html"
    PDF = "pdf", "output: report.pdf"
    PNG = "png", "output: the figures as PNG files"
    SVG = "svg", "output: the figures as SVG files"
    FIGURE_PDF = "figure-pdf", "output: the figures as PDF files"
    JSON = "json", "output: results.json"
    CSV = "csv", "output: branches.csv"
    JUNIT = "junit", "output: junit.xml, the requirements as test cases"
    MARKDOWN = "markdown", "output: summary.md, for the page of a job"
    GITHUB = "github", "output: annotations on standard output"


class AddedTask(str):
    """What a run can do that an addition to a study does; by its name it stands where a `Task` does.

    Parameters
    ----------
    name : str
        That of a figure begins with ``figure-``.
    what : str
        What it is, for the reader.
    """

    what: str

    def __new__(cls, name: str, what: str) -> AddedTask:
        """Make the task whose value is `name`."""
        task = str.__new__(cls, name)
        task.what = what
        return task

    def __reduce__(self) -> tuple[type[AddedTask], tuple[str, str]]:
        """The text and the words of which a copy is made."""
        return AddedTask, (str(self), self.what)


AnyTask = Task | AddedTask

FIGURES = (
    *(Task.FIGURE_ANSWER, Task.FIGURE_2, Task.FIGURE_3, Task.FIGURE_4, Task.FIGURE_6, Task.FIGURE_7),
    *(Task.FIGURE_DEVICE, Task.FIGURE_MARGINS, Task.FIGURE_CYCLE),
    *(Task.FIGURE_DIAGRAM, Task.FIGURE_HYSTERESIS),
    *(Task.FIGURE_ATLAS, Task.FIGURE_LADDER, Task.FIGURE_PORTRAITS),
)

FIGURES_OF_PAGES = (Task.FIGURE_ANSWER, Task.FIGURE_DEVICE, Task.FIGURE_MARGINS, Task.FIGURE_CYCLE)
"""Figures that are on the pages of a run; as files of their own they are written where formats are asked for."""

FIGURE_SUFFIXES = {Task.PNG: "png", Task.SVG: "svg", Task.FIGURE_PDF: "pdf"}

FIGURE_FORMATS = tuple(FIGURE_SUFFIXES)
"""In which each figure is a file of its own."""


def page_and_figure_files(figures: Iterable[str]) -> dict[Task, tuple[str, ...]]:
    """The files of a report and of its figures, by their formats."""
    names = tuple(figures)
    drawn = {task: tuple(f"{name}.{suffix}" for name in names) for task, suffix in FIGURE_SUFFIXES.items()}
    return {Task.HTML: ("report.html",), Task.PDF: ("report.pdf",), **drawn}


FORMATS = (Task.HTML, Task.PDF, Task.PNG, Task.JSON, Task.CSV)
"""What is written by default."""

ALL_FORMATS = (*FORMATS, Task.SVG, Task.FIGURE_PDF, Task.JUNIT, Task.MARKDOWN, Task.GITHUB)
"""What `--format` can ask for; the last three are for systems that run jobs."""


class Addition(StrEnum):
    """What a scenario can be given, so that a run does more: a block, or values of a device.

    Attributes
    ----------
    is_block : bool
        Whether it is a block that no other value of the scenario needs.
    """

    is_block: bool

    def __new__(cls, name: str, is_block: bool = False) -> Addition:
        """Make the member whose value is `name`."""
        member = str.__new__(cls, name)
        member._value_, member.is_block = name, is_block
        return member

    MOTIONS = "motions", True
    SIMULATION = "simulation", True
    SWEEP = "sweep"
    DESIGN_POINT = "design point"
    BALL_MASS = "ball mass"
    DIELECTRIC = "dielectric"


class AddedBlock(str):
    """The block by which an addition to a study does more; its words of the same name say what, as `gain`."""

    is_block = True


class Step(Struct, frozen=True, eq=False):
    """One thing that a run could do.

    Attributes
    ----------
    task : Task or AddedTask
    runs : bool
    what : str
        What it is, for the reader.
    why : str
        Why it runs, or why it is left out.
    lacks : str
        The optional package that is missing and without which it is left out, or less than it could be; "" where none
        is.
    lessened : str
        In what way it is less without that.
    adds : Addition, AddedBlock or None
        With which it would run, where it is left out for want of that.
    """

    task: AnyTask
    runs: bool
    what: str
    why: str
    lacks: str = ""
    lessened: str = ""
    adds: Addition | AddedBlock | None = None


LEFT_OUT, SLOWER = "left out", "some hundred times slower"
"""What a missing package does to steps."""


class Plan(Struct, frozen=True, eq=False):
    """The steps of a run, in their order.

    Attributes
    ----------
    steps : tuple of Step
    additions : tuple of Addition or AddedBlock
        What could be added to the scenario for steps that are left out, in the order of `Addition`; blocks of additions
        to a study after its first.
    parameter : str
        Key of the value that a design point has of what is swept.
    """

    steps: tuple[Step, ...]
    additions: tuple[Addition | AddedBlock, ...]
    parameter: str

    def __repr__(self) -> str:
        return f"<Plan: {len(self.steps) - len(self.left_out)} steps run, {len(self.left_out)} are left out>"

    def _repr_html_(self) -> str:
        """The steps and why each runs or does not, for a notebook."""
        from vireport.text.tables import html_table

        rows = [("run" if step.runs else "skip", step.task, step.what, step.why) for step in self.steps]
        return html_table(("", "Step", "What it is", "Why"), rows)

    def runs(self, *tasks: str) -> bool:
        """Whether any of the tasks is part of the run."""
        return any(step.runs for step in self.steps if step.task in tasks)

    def running(self, task: str) -> AnyTask | None:
        """The task of a name as it is declared, with what it is; None where it is no part of the run."""
        return next((step.task for step in self.steps if step.runs and step.task == task), None)

    @property
    def left_out(self) -> tuple[Step, ...]:
        """The steps that do not run."""
        return tuple(step for step in self.steps if not step.runs)

    def reason(self, task: str) -> str | None:
        """Why a task is left out; None where it runs, or is not listed."""
        return next((step.why for step in self.left_out if step.task == task), None)

    def left_out_lines(self, templates: Path | None = None) -> tuple[str, ...]:
        """What to add to the scenario for more than a run does, and where every step that is left out is listed.

        Three lines at most, in the words of `templates`.
        """
        from vireport.text.templates import Words

        blocks = [addition for addition in self.additions if addition.is_block]
        inputs = [addition for addition in self.additions if not addition.is_block]
        adding = "add_or_all" if any(addition in ADDED_IF_FULL for addition in blocks) else "add"
        gains = [Words(block, templates)("gain") if isinstance(block, AddedBlock) else block for block in blocks]
        whole = (" and ".join((", ".join(ADDED_IF_FULL[:-1]), ADDED_IF_FULL[-1])),) if adding == "add_or_all" else ()
        wording = ((adding, gains, whole), ("give", inputs, ()))
        lines = [(macro, wanted, more) for macro, wanted, more in wording if wanted]
        say = Words("left-out", templates)
        searched = (step.what for step in self.left_out if step.task is Task.OPTIMISE)
        last = *(f"{capital(text)}." for text in (*searched, *self.lacking)), say("every_step")
        return *(say(macro, wanted, self.parameter, *more) for macro, wanted, more in lines), " ".join(last)

    @property
    def lacking(self) -> tuple[str, ...]:
        """What missing packages leave out or slow down, a line for each package, with the command that installs it."""
        lines = []
        for package in dict.fromkeys(step.lacks for step in self.steps if step.lacks):
            ways: dict[str, list[str]] = {}
            for step in self.steps:
                if step.lacks == package:
                    ways.setdefault(step.lessened if step.runs else LEFT_OUT, []).append(step.task)
            text = "; ".join(f"{way}: {', '.join(tasks)}" for way, tasks in ways.items())
            lines.append(f"the package {package} is missing: {install_command(package)} ({text})")
        return tuple(lines)


class Precondition(NamedTuple):
    """What must hold of a scenario and the formats asked for, and what to say where it does not.

    `package` is the optional one that must be there, if it is that which must hold, and `adds` what makes it hold.
    """

    holds: Callable[[Scenario, frozenset[str]], object]
    otherwise: str
    package: str = ""
    adds: Addition | AddedBlock | None = None


class DeclaredStep(NamedTuple):
    """A step as it is declared; it is listed, as run or as left out, only where all of `listed` holds.

    Without the package of `better` it runs, and is `lessened`. Where it runs, `costs` says what it is with what it
    takes. One of an addition stands before the step `before` of the core.
    """

    task: AnyTask
    needs: tuple[Precondition, ...]
    why: str
    listed: tuple[Precondition, ...] = ()
    better: Precondition | None = None
    lessened: str = ""
    costs: Callable[[Scenario], str] | None = None
    before: Task = Task.MEASURED


def _format(task: Task) -> Precondition:
    return Precondition(lambda _, formats: task in formats, "not among the formats asked for")


SWEEP = Precondition(
    lambda scenario, _: scenario.sweep,
    "no sweep: a single design point has no branches to follow",
    adds=Addition.SWEEP,
)
HORIZONTAL = Precondition(
    lambda scenario, _: scenario.inclination_deg == 0 and scenario.parameter is not Parameter.INCLINATION,
    "gravity along the capsule: no motion is symmetric for beta > 0",
)
ALIKE = Precondition(
    lambda scenario, _: scenario.device.alike,
    "the restitutions of both membranes differ: no motion is symmetric",
)


def _without(special: Special) -> Precondition:
    """That the ball is not special in one way."""
    return Precondition(
        lambda scenario, _: not getattr(scenario.device, special.name),
        f"it is available {special.plain} only, and {special.key} is given",
    )


FRICTIONLESS, CONSTANT = map(_without, SPECIAL)
ODD_HARMONICS = Precondition(
    lambda scenario, _: all(harmonic.order % 2 or not harmonic.percent for harmonic in scenario.excitation.harmonics),
    "the force has an even harmonic: no motion is symmetric",
)
ODD = Precondition(lambda scenario, _: scenario.period_ratio % 2, "for an even period ratio no motion is symmetric")
DESIGN = Precondition(
    lambda scenario, _: scenario.value_of(scenario.parameter) is not None,
    "{parameter} is not given",
    adds=Addition.DESIGN_POINT,
)
NO_DESIGN = Precondition(lambda scenario, _: scenario.value_of(scenario.parameter) is None, "{parameter} is given")
BALL = Precondition(
    lambda scenario, _: scenario.device.ball_mass_kg, "device.ball_mass_kg is not given", adds=Addition.BALL_MASS
)
DIELECTRIC = Precondition(
    lambda scenario, _: scenario.device.membrane and scenario.device.membrane.thickness_m,
    "thickness_m, relative_permittivity and breakdown_field_v_m of device.membrane are not given",
    adds=Addition.DIELECTRIC,
)
SIMULATION = Precondition(
    lambda scenario, _: scenario.simulation, "the scenario has no simulation block", adds=Addition.SIMULATION
)
NO_SIMULATION = Precondition(
    lambda scenario, _: not scenario.simulation, "the motions that the simulation block finds are drawn"
)
PORTRAITS = Precondition(
    lambda scenario, _: scenario.simulation and scenario.simulation.portraits, "simulation.portraits is empty"
)
DISPLACEMENT = Precondition(
    lambda scenario, _: scenario.simulation and scenario.simulation.displacement, "simulation.displacement is empty"
)
DIAGRAM = Precondition(
    lambda scenario, _: scenario.simulation and scenario.simulation.diagram, "simulation.diagram is false"
)
FOLLOW = Precondition(
    lambda scenario, _: scenario.simulation and scenario.simulation.follow is not Direction.NONE,
    "simulation.follow is none",
)
MOTIONS = Precondition(
    lambda scenario, _: motion_limits(scenario), "the scenario has no motions block", adds=Addition.MOTIONS
)
ONE_TO_ONE = Precondition(lambda scenario, _: not on_table(scenario), "on a table no motion is 1:1")
SEEN = Precondition(lambda scenario, _: not on_table(scenario) or motion_limits(scenario), ONE_TO_ONE.otherwise)
NAMED = Precondition(lambda scenario, _: scenario.motions and scenario.motions.portraits, "motions.portraits is empty")
DISTORTED = Precondition(
    lambda scenario, formats: (
        (value_at(scenario, "disturbances") and formats)
        or (scenario.requirements and scenario.requirements.withstands_distortion_percent is not None)
    ),
    "neither a disturbances block nor requirements.withstands_distortion_percent asks for it",
    adds=AddedBlock("disturbances") if "outcomes" in ADDITIONS else None,
)


def motion_limits(scenario: Scenario) -> MotionsBlock | None:
    """Limits of the motions that are followed: those given, or what requirements or a table need; None where none is.

    Above a table, a bottom whose top is out of reach, no motion is a 1:1 motion.
    """
    allowed = scenario.requirements.allowed if scenario.requirements is not None else ()
    implied = on_table(scenario) and "motions" not in barred_blocks(scenario)
    if scenario.motions is not None or not (allowed or implied):
        return scenario.motions
    least = MotionsBlock()
    impacts = max([least.impacts, *map(len, allowed)])
    return MotionsBlock(impacts=impacts, periods=max(least.periods, scenario.period_ratio))


def on_table(scenario: Scenario) -> bool:
    """Whether a device is a ball on a table along a sweep, so that no motion there is 1:1."""
    if scenario.sweep is None:
        return False
    return is_table(Device.of(scenario), scenario.parameter, (scenario.sweep.from_, scenario.sweep.to))


def _package(name: str, module: str) -> Precondition:
    """That an optional package is there: the one place that says which step needs which."""
    return Precondition(
        lambda *_: find_spec(module), f"the package {name} is missing: {install_command(name)}", package=name
    )


def has_block(name: str) -> Precondition:
    """That the block of an addition is given; the words of that name say in a macro `gain` what for."""
    return Precondition(
        lambda scenario, _: getattr(scenario, name), f"the scenario has no {name} block", adds=AddedBlock(name)
    )


FLINT = _package("python-flint", "flint")
MPMATH = _package("mpmath", "mpmath")
NUMBA = _package("numba", "numba")


def simulation_compiles() -> bool:
    """Whether the package is installed that compiles the simulation."""
    return find_spec("numba") is not None


MEASURED = Precondition(lambda scenario, _: scenario.measured, "the scenario has no measured block")
REQUIREMENTS = Precondition(lambda scenario, _: scenario.requirements, "the scenario has no requirements block")
BEST = Precondition(lambda scenario, _: scenario.design, "the scenario has no design block")
NOT_IN_A_RUN = Precondition(lambda *_: False, "a run takes the design as it is; vireport optimise looks for the best")
PICTURES = Precondition(
    lambda _, formats: formats & {Task.HTML, Task.PDF, *FIGURE_FORMATS}, "no figure, HTML or PDF is asked for"
)

CIRCLED = Precondition(
    lambda scenario, formats: PICTURES.holds(scenario, formats) or MOTIONS.holds(scenario, formats),
    PICTURES.otherwise,
)

OUTPUT = Precondition(lambda _, formats: formats, "no output is asked for: designs of a search are only judged")

SHIFTS = Precondition(
    lambda scenario, formats: (
        formats or (scenario.requirements and scenario.requirements.margin_with_effects_percent is not None)
    ),
    OUTPUT.otherwise,
)

SUMMARISED = Precondition(
    lambda _, formats: formats & {Task.HTML, Task.PDF, Task.MARKDOWN}, "neither HTML, PDF nor Markdown is asked for"
)

JUMP = 2000
"""Times the impacts of a start that it takes to find where a motion that is followed jumps: an estimate, next to which
what lies between jumps takes little."""

IMPACTS_PER_SECOND = 2e6
"""Speed of the simulation on one core of a common machine, for what a plan says of its cost."""

INTERPRETED_PER_SECOND = 3e4
"""Speed of the simulation where it is not compiled."""


def _simulated(scenario: Scenario) -> str:
    """The simulation, with what it will cost."""
    block = scenario.simulation
    if block is None:
        return Task.SIMULATION.what
    values = block.samples if scenario.sweep is not None else 1
    rate, remark = IMPACTS_PER_SECOND, "the first time, a few seconds more to compile"
    if not simulation_compiles():
        rate, remark = INTERPRETED_PER_SECOND, f"interpreted, as numba is missing: {install_command('numba')}"
    cost = f"about {values * block.starts * block.impacts / rate:.1g} s"
    if block.follow is not Direction.NONE:
        jump = f"about {JUMP * block.impacts / rate:.1g} s for each jump"
        cost += f", then followed from value to value ({block.follow}), {jump}"
    return f"simulation: {values} x {block.starts} starts x {block.impacts} impacts, {cost}; {remark}"


FOLLOWED_S, COEXISTING_S, LONG_WORDS_S = 0.5, 2.0, 60.0
"""What families take in each forcing period where few motions coexist, and where many do; and in the latter case those
of more impacts than are looked for, up to the bound on them: of the order."""


def _followed(scenario: Scenario) -> str:
    """The families of motions, with what they will take."""
    from vireport.motions.atlas.families import LOOKED_FOR

    limits = motion_limits(scenario)
    if limits is None:
        return Task.MOTIONS.what
    most = COEXISTING_S * limits.periods + (LONG_WORDS_S if limits.impacts > LOOKED_FOR else 0.0)
    least, periods = FOLLOWED_S * limits.periods, "periods" if limits.periods > 1 else "period"
    bounds = f"at most {limits.impacts} impacts in {limits.periods} forcing {periods}"
    time = f"about {least:g} s, or up to {most:.0f} s where many coexist (restitution near 1, wide sweeps)"
    return f"{Task.MOTIONS.what}, {bounds}, {time}"


def _search(scenario: Scenario) -> str:
    """The best design, with what its search will take: a run for each of the best cells, where these are needed."""
    costly = scenario.tolerances or motion_limits(scenario) or scenario.simulation
    return f"{Task.OPTIMISE.what}, by vireport optimise: {'minutes' if costly else 'about 20 s'}"


STEPS = (
    DeclaredStep(Task.BRANCHES, (SWEEP,), "a sweep is given"),
    DeclaredStep(Task.SYMMETRIC, (HORIZONTAL, ALIKE, ODD, ODD_HARMONICS), "the capsule is horizontal"),
    DeclaredStep(Task.CRITICAL, (SWEEP, ONE_TO_ONE), "a sweep is given"),
    DeclaredStep(Task.DESIGN, (DESIGN,), "the design point is given"),
    DeclaredStep(Task.DISTORTION, (DISTORTED, DESIGN), "a disturbances block, or a requirement, asks for it"),
    DeclaredStep(Task.EFFECTS, (DESIGN, SHIFTS), "the design point is given"),
    DeclaredStep(Task.ENERGY, (BALL,), "the ball mass is given"),
    DeclaredStep(Task.CONVERSION, (BALL, DIELECTRIC, DESIGN), "the membrane's dielectric is given"),
    DeclaredStep(Task.FROM_REST, (DESIGN,), "the design point is given"),
    DeclaredStep(Task.SAMPLED_FROM_REST, (FRICTIONLESS,), "a sweep is given, and no design point", (NO_DESIGN,)),
    DeclaredStep(Task.MEASURED, (OUTPUT,), "the scenario has a measured block", (MEASURED,)),
    DeclaredStep(Task.REPRODUCTION, (SUMMARISED,), "a report is asked for"),
    DeclaredStep(Task.FIGURE_ANSWER, (SWEEP, ONE_TO_ONE, PICTURES), "a sweep is given"),
    DeclaredStep(Task.FIGURE_2, (SWEEP, SEEN, PICTURES), "a sweep is given"),
    DeclaredStep(Task.FIGURE_4, (SWEEP, ONE_TO_ONE, PICTURES), "a sweep is given"),
    DeclaredStep(Task.FIGURE_7, (SWEEP, ONE_TO_ONE, BALL, PICTURES), "a sweep and the ball mass are given"),
    DeclaredStep(Task.CIRCLES, (SWEEP, CIRCLED), "a sweep is drawn, or its families are followed", (NO_SIMULATION,)),
    DeclaredStep(Task.SIMULATION, (SIMULATION,), "the scenario has a simulation block", (), NUMBA, SLOWER, _simulated),
    DeclaredStep(Task.FIGURE_3, (SIMULATION, PORTRAITS, PICTURES), "simulation.portraits names values"),
    DeclaredStep(Task.FIGURE_6, (SIMULATION, DISPLACEMENT, PICTURES), "simulation.displacement names values"),
    DeclaredStep(
        Task.MOTIONS,
        (SWEEP, MOTIONS),
        "a motions block, a word that is required, or a ball on a table asks for them",
        costs=_followed,
    ),
    DeclaredStep(Task.FIGURE_DEVICE, (PICTURES,), "every scenario has a device"),
    DeclaredStep(Task.FIGURE_MARGINS, (DESIGN, PICTURES), "the design point is given"),
    DeclaredStep(Task.FIGURE_CYCLE, (DESIGN, PICTURES), "the membrane's dielectric is given", (DIELECTRIC,)),
    DeclaredStep(Task.OWN_STIFFNESS, (BALL, FRICTIONLESS, CONSTANT), "the ball mass is given"),
    DeclaredStep(Task.FIGURE_DIAGRAM, (SIMULATION, SWEEP, DIAGRAM, PICTURES), "simulation.diagram is true"),
    DeclaredStep(Task.FIGURE_HYSTERESIS, (PICTURES,), "simulation.follow is given", (FOLLOW,)),
    DeclaredStep(Task.FIGURE_ATLAS, (SWEEP, PICTURES), "motions of other impact sequences are followed", (MOTIONS,)),
    DeclaredStep(Task.FIGURE_LADDER, (SWEEP, BALL, PICTURES), "the scenario has a motions block", (MOTIONS,)),
    DeclaredStep(Task.FIGURE_PORTRAITS, (SWEEP, NAMED, PICTURES), "motions.portraits names motions", (MOTIONS,)),
    DeclaredStep(Task.REQUIREMENTS, (), "the scenario has a requirements block", (REQUIREMENTS,)),
    DeclaredStep(Task.OPTIMISE, (NOT_IN_A_RUN,), "", (BEST,), costs=_search),
    DeclaredStep(Task.HTML, (_format(Task.HTML),), "asked for"),
    DeclaredStep(Task.PDF, (_format(Task.PDF),), "asked for"),
    DeclaredStep(Task.PNG, (_format(Task.PNG),), "asked for"),
    DeclaredStep(Task.SVG, (), "asked for", (_format(Task.SVG),)),
    DeclaredStep(Task.FIGURE_PDF, (), "asked for", (_format(Task.FIGURE_PDF),)),
    DeclaredStep(Task.JSON, (_format(Task.JSON),), "asked for"),
    DeclaredStep(Task.CSV, (_format(Task.CSV), SWEEP), "asked for"),
    DeclaredStep(Task.JUNIT, (), "asked for", (_format(Task.JUNIT),)),
    DeclaredStep(Task.MARKDOWN, (), "asked for", (_format(Task.MARKDOWN),)),
    DeclaredStep(Task.GITHUB, (), "asked for", (_format(Task.GITHUB),)),
)


@cache
def declared_steps() -> tuple[DeclaredStep, ...]:
    """All steps in their order, those of additions among those of the core."""
    added: dict[Task, list[DeclaredStep]] = {}
    for finding in findings().values():
        for row in finding.steps():
            added.setdefault(row.before, []).append(row)
    return tuple(step for row in STEPS for step in (*added.get(Task(row.task), ()), row))


@cache
def _known_additions() -> tuple[Addition | AddedBlock, ...]:
    """What a scenario can be given, a block of an addition before what belongs to later steps than its own."""
    first: dict[Addition | AddedBlock, int] = {}
    for k, step in enumerate(declared_steps()):
        for need in step.needs:
            if need.adds is not None:
                first.setdefault(need.adds, k)
    additions: list[Addition | AddedBlock] = list(Addition)
    for block, place in first.items():
        if isinstance(block, AddedBlock):
            later = (k for k, other in enumerate(additions) if first.get(other, -1) > place)
            additions.insert(next(later, len(additions)), block)
    return tuple(additions)


def figures() -> tuple[AnyTask, ...]:
    """The figures that a run can draw: those of the core, and those of additions."""
    added = (row.task for row in declared_steps() if isinstance(row.task, AddedTask))
    return (*FIGURES, *(task for task in added if task.startswith("figure-")))


def plan(scenario: Scenario, formats: Iterable[str] = FORMATS) -> Plan:
    """Derive the steps from a scenario and the outputs asked for.

    Parameters
    ----------
    scenario : Scenario
    formats : iterable of str
        Among `ALL_FORMATS`.
    """
    wanted_formats, steps = frozenset(formats), []
    for row in declared_steps():
        if all(need.holds(scenario, wanted_formats) for need in row.listed):
            failing = next((need for need in row.needs if not need.holds(scenario, wanted_formats)), None)
            why = row.why if failing is None else failing.otherwise.format(parameter=scenario.parameter.path)
            runs, what = failing is None, row.task.what
            if row.costs is not None and (runs or row.task is Task.OPTIMISE):
                what = row.costs(scenario)
            # A step that is left out for something else, too, lacks no package.
            lacking = [need for need in (*row.needs, row.better) if need and not need.holds(scenario, wanted_formats)]
            lacks = lacking[0].package if lacking and all(need.package for need in lacking) else ""
            adds = failing.adds if failing is not None else None
            steps.append(Step(row.task, runs, what, why, lacks, row.lessened, adds))
    wanted = {step.adds for step in steps if not step.runs} - {*barred_blocks(scenario)}
    additions = tuple(addition for addition in _known_additions() if addition in wanted)
    return Plan(tuple(steps), additions, scenario.parameter.path)


def refuse_special(scenario: Scenario, what: str) -> None:
    """Refuse a scenario for what is available for a sine and a plain ball only, before anything is computed.

    Raises
    ------
    UsageError
        If the force has harmonics, or the ball friction or a restitution that falls with speed.
    """
    if scenario.excitation.distorted:
        raise UsageError(
            f"{what} is available for a sine force only, and excitation.harmonics is given (leave one of them out)"
        )
    for special in SPECIAL:
        if getattr(scenario.device, special.name):
            raise UsageError(
                f"{what} is available {special.plain} only, and {special.key} is given "
                "(leave one of them out, or give 0)"
            )


def require_proofs() -> None:
    """Refuse to prove what cannot be proved here, before anything is computed.

    Raises
    ------
    NumericalError
        If the package that proves is missing.
    """
    if not find_spec("flint"):
        raise NumericalError(f"--certify: {FLINT.otherwise}")


def require_reference() -> None:
    """Refuse to measure errors where there is nothing to measure them against, before anything is computed.

    Raises
    ------
    NumericalError
        If the package that computes with 40 digits is missing.
    """
    if not find_spec("mpmath"):
        raise NumericalError(f"vireport verify: {MPMATH.otherwise}")


def refuse_undecidable(scenario: Scenario) -> None:
    """Refuse a scenario whose requirements cannot be judged here, before anything is computed.

    Raises
    ------
    UsageError
        If a search that one needs lacks what it needs itself.
    """
    for finding in findings().values():
        finding.refuse_undecidable(scenario)
