"""What a run has to do: derived from the scenario and the outputs asked for, before anything is computed.

A run follows its plan; what the plan leaves out is neither computed, nor imported, nor drawn.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from vireport.scenario import (
    SWEEPABLE,
    Scenario,
)

OUTPUTS = {
    "html": "report.html",
    "pdf": "report.pdf",
    "png": "the figures as PNG files",
    "json": "results.json",
    "csv": "branches.csv",
}

FORMATS = tuple(OUTPUTS)
"""What is written by default."""

CI_OUTPUTS = {
    "junit": "junit.xml, the requirements as test cases",
    "markdown": "summary.md, for the page of a job",
    "github": "annotations on standard output",
}
"""Outputs for systems that run jobs; only where they are asked for."""

ALL_FORMATS = (*OUTPUTS, *CI_OUTPUTS)
"""What `--format` can ask for."""


MEASURED_FIGURES = {
    "figure-accuracy": "work-precision diagram",
    "figure-stiffness": "solvers on stiff membranes",
}
"""Figures of an accuracy block."""


@dataclass(frozen=True, slots=True)
class Step:
    """One thing that a run could do.

    Attributes
    ----------
    name : str
        Key of the step.
    runs : bool
    what : str
        What it is, for the reader.
    why : str
        Why it runs, or why it is left out.
    """

    name: str
    runs: bool
    what: str
    why: str


@dataclass(frozen=True, slots=True)
class Plan:
    """The steps of a run, in their order."""

    steps: tuple[Step, ...]

    def runs(self, name: str) -> bool:
        """Whether a step is part of the run."""
        return any(step.name == name and step.runs for step in self.steps)

    @property
    def left_out(self) -> tuple[Step, ...]:
        """The steps that do not run."""
        return tuple(step for step in self.steps if not step.runs)


def plan(scenario: Scenario, formats: Iterable[str] = FORMATS) -> Plan:
    """Derive the steps from a scenario and the outputs asked for.

    Parameters
    ----------
    scenario : Scenario
    formats : iterable of str
        Among `ALL_FORMATS`.
    """
    asked = set(formats)
    swept = scenario.sweep is not None
    designed = design_value(scenario) is not None
    energy = scenario.device.ball_mass_kg is not None
    horizontal = scenario.inclination_deg == 0 and (not swept or scenario.sweep.parameter != "inclination_deg")  # type: ignore[union-attr]
    pictures = bool(asked & {"html", "pdf", "png"})
    no_sweep = "no sweep: a single design point has no branches to follow"
    no_mass = "device.ball_mass_kg is not given"
    not_asked = "no figure, HTML or PDF is asked for"

    def step(name: str, what: str, *conditions: tuple[bool, str], why: str) -> Step:
        failing = next((reason for holds, reason in conditions if not holds), None)
        return Step(name, failing is None, what, failing or why)

    simulated = scenario.simulation is not None
    no_simulation = "the scenario has no simulation block"
    block = scenario.simulation
    measured, no_accuracy = scenario.accuracy is not None, "the scenario has no accuracy block"
    asked_for = "the scenario has an accuracy block"
    drawn = (pictures, not_asked)

    return Plan(
        (
            step(
                "branches",
                "branches of 1:1 motions along the sweep, admissibility and stability",
                (swept, no_sweep),
                why="a sweep is given",
            ),
            step(
                "symmetric",
                "the symmetric family",
                (horizontal, "gravity along the capsule: no motion is symmetric for beta > 0"),
                (scenario.period_ratio % 2 == 1, "for an even period ratio no motion is symmetric"),
                why="the capsule is horizontal",
            ),
            step("critical", "critical points and Table 1", (swept, no_sweep), why="a sweep is given"),
            step(
                "design",
                "the motions at the design point and their margins",
                (designed, f"{_path(scenario)} is not given"),
                why="the design point is given",
            ),
            step("energy", "voltages", (energy, no_mass), why="the ball mass is given"),
            step(
                "figure-2",
                "figure 2: impact velocity, phase and flight time",
                (swept, no_sweep),
                (pictures, not_asked),
                why="a sweep is given",
            ),
            step(
                "figure-4",
                "figure 4: Delta and the eigenvalues",
                (swept, no_sweep),
                (pictures, not_asked),
                why="a sweep is given",
            ),
            step(
                "figure-7",
                "figure 7: voltages",
                (swept, no_sweep),
                (energy, no_mass),
                (pictures, not_asked),
                why="a sweep and the ball mass are given",
            ),
            step("simulation", _cost(scenario), (simulated, no_simulation), why="the scenario has a simulation block"),
            step(
                "figure-3",
                "figure 3: phase portraits and time series",
                (simulated, no_simulation),
                (bool(block and block.portraits), "simulation.portraits is empty"),
                drawn,
                why="simulation.portraits names values",
            ),
            step(
                "figure-6",
                "figure 6: displacement of the capsule's ends and of the ball",
                (simulated, no_simulation),
                (bool(block and block.displacement), "simulation.displacement is empty"),
                drawn,
                why="simulation.displacement names values",
            ),
            step("accuracy", "error against run time of several methods", (measured, no_accuracy), why=asked_for),
            step(
                "compliant",
                "the motion with compliant membranes, and solvers on stiff ones",
                (measured, no_accuracy),
                (
                    bool(scenario.accuracy and scenario.accuracy.compliant_membrane),
                    "accuracy.compliant_membrane is false",
                ),
                (energy, no_mass),
                why=asked_for,
            ),
            *(
                step(name, what, drawn, why=asked_for)
                for name, what in MEASURED_FIGURES.items()
                if measured and (name == "figure-accuracy" or energy)
            ),
            step(
                "figure-diagram",
                "bifurcation diagram by simulation",
                (simulated, no_simulation),
                (swept, no_sweep),
                (bool(block and block.diagram), "simulation.diagram is false"),
                drawn,
                why="simulation.diagram is true",
            ),
            *(
                [step("requirements", "the acceptance table", why="the scenario has a requirements block")]
                if scenario.requirements is not None
                else []
            ),
            *(
                step(
                    name,
                    f"output: {what}",
                    (name in asked, "not among the formats asked for"),
                    (swept or name not in ("png", "csv"), no_sweep),
                    why="asked for",
                )
                for name, what in OUTPUTS.items()
            ),
            *(step(name, f"output: {what}", why="asked for") for name, what in CI_OUTPUTS.items() if name in asked),
        )
    )


IMPACTS_PER_SECOND = 2e6
"""Of the simulation on one core of a common machine, for what a plan says of its cost."""


def _cost(scenario: Scenario) -> str:
    """The simulation, with what it will cost."""
    asked = scenario.simulation
    if asked is None:
        return "simulation of the sampled motions"
    values = asked.samples if scenario.sweep is not None else 1
    impacts = values * asked.starts * asked.impacts * (2 if asked.diagram else 1)
    return (
        f"simulation: {values} x {asked.starts} starts x {asked.impacts} impacts, about "
        f"{impacts / IMPACTS_PER_SECOND:.1g} s and, the first time, a few seconds to compile"
    )


def design_value(scenario: Scenario) -> float | None:
    """Value of the swept parameter (of the length where none is) at the design point, None where it is not given."""
    values = {
        "length_m": scenario.device.length_m,
        "amplitude_n": scenario.excitation.amplitude_n,
        "frequency_hz": scenario.excitation.frequency_hz,
        "inclination_deg": scenario.inclination_deg,
    }
    return values[scenario.sweep.parameter if scenario.sweep else "length_m"]


def _path(scenario: Scenario) -> str:
    return SWEEPABLE[scenario.sweep.parameter if scenario.sweep else "length_m"]
