"""Everything that is found out about one scenario, gathered step by step as its plan says."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from vireport.analysis.design import DesignPoint, StableInterval, design_point, stable_ranges
from vireport.analysis.motions import Motions, impact_velocities
from vireport.analysis.solution import Solution, solve
from vireport.analysis.table import Row, table
from vireport.errors import NumericalError
from vireport.gate.alerts import Alert, alerts
from vireport.physics.device import Device, Sweep
from vireport.physics.energy import Membrane, Voltages, voltages
from vireport.scenario import blocks
from vireport.scenario.blocks import Scenario
from vireport.scenario.loading import Loaded
from vireport.study.plan import FORMATS, Plan, plan

if TYPE_CHECKING:
    from vireport.analysis.certify import Certificate
    from vireport.analysis.uncertainty import Bounds
    from vireport.gate.criteria import Criterion
    from vireport.trust.compliance import Compliance
    from vireport.trust.crosscheck import CrossCheck
    from vireport.trust.timing import Progress
    from vireport.trust.workprecision import WorkPrecision


SMALLEST_LOSS = 1e-6
"""1 - r below which the motions are not resolved: they draw together as 1 - r, and det DP = r^4 comes too near to 1."""


@dataclass(frozen=True, eq=False)
class Study:
    """The results of one scenario; what its plan leaves out is None or empty.

    Attributes
    ----------
    loaded : Loaded
        The scenario and where it came from.
    plan : Plan
    device : Device
    sweep : Sweep or None
    solution : Solution or None
        Branches and critical points.
    table : tuple of Row
        Table 1 for this scenario.
    stable_ranges : tuple of StableInterval
    design : DesignPoint or None
    membrane : Membrane or None
        None where no energy is evaluated.
    voltages : tuple of Voltages
        One for each branch.
    design_voltages : Voltages or None
    crosscheck : CrossCheck or None
        What the simulation found.
    work : WorkPrecision or None
        Error against run time of several methods.
    compliance : Compliance or None
        The motion with compliant membranes.
    certificates : tuple of Certificate or None
        Proven enclosures of the critical points.
    criteria : tuple of Criterion
        What the scenario requires, and whether it is met; () where nothing is required.
    """

    loaded: Loaded
    plan: Plan
    device: Device
    sweep: Sweep | None
    solution: Solution | None
    table: tuple[Row, ...]
    stable_ranges: tuple[StableInterval, ...]
    design: DesignPoint | None
    membrane: Membrane | None
    voltages: tuple[Voltages, ...]
    design_voltages: Voltages | None
    crosscheck: CrossCheck | None = None
    work: WorkPrecision | None = None
    compliance: Compliance | None = None
    certificates: tuple[Certificate, ...] | None = None
    criteria: tuple[Criterion, ...] = ()

    @property
    def scenario(self) -> Scenario:
        """The scenario as understood."""
        return self.loaded.scenario

    @property
    def horizontal(self) -> bool:
        """Whether gravity has no part along the capsule anywhere in the study."""
        return self.plan.runs("symmetric")

    @cached_property
    def bounds(self) -> Bounds:
        """Error bounds of all motions and voltages."""
        from vireport.analysis.uncertainty import bounds_of

        return bounds_of(self)

    @cached_property
    def alerts(self) -> tuple[Alert, ...]:
        """What a reader must know before acting on the numbers."""
        return alerts(self)

    def to_dict(self) -> dict[str, Any]:
        """The results as plain data, as results.json has them."""
        return dict(import_module("vireport.report.notebooks").study_dict(self))

    def rows(self) -> list[dict[str, Any]]:
        """Every motion of every branch as a dict, by the names of branches.csv; for a data frame."""
        return list(import_module("vireport.report.notebooks").study_rows(self))

    def _repr_html_(self) -> str:
        return str(import_module("vireport.report.notebooks").study_html(self))


def device_of(scenario: Scenario) -> Device:
    """The device of a scenario; a swept parameter is None where no design point is given."""
    return Device(
        capsule_mass_kg=scenario.device.capsule_mass_kg,
        restitution=scenario.device.restitution,
        gravity_m_s2=scenario.gravity_m_s2,
        length_m=scenario.device.length_m,
        amplitude_n=scenario.excitation.amplitude_n,
        frequency_hz=scenario.excitation.frequency_hz,
        inclination_deg=scenario.inclination_deg,
        period_ratio=scenario.period_ratio,
    )


def analyse(loaded: Loaded, formats: Iterable[str] = FORMATS, progress: Progress | None = None) -> Study:
    """Solve a scenario: motions, admissibility, stability, critical points, voltages, simulation, as its plan says.

    Parameters
    ----------
    loaded : Loaded
        From `scenario.load`.
    formats : iterable of str
        Outputs that are wanted, among `plan.FORMATS`.
    progress : callable, optional
        Told each long step as it begins.

    Raises
    ------
    NumericalError
        If the scenario is outside the theory (restitution 1), or a point cannot be computed to its error bound.
    """
    scenario, steps = loaded.scenario, plan(loaded.scenario, formats)
    device = device_of(scenario)
    if 1 - device.restitution < SMALLEST_LOSS:
        raise NumericalError(
            f"device.restitution: {device.restitution!r} means impacts with hardly any loss; for 1 periodic motions "
            "come in continua and none is asymptotically stable, so that the criteria of Table 1 do not apply "
            f"(allowed here: at most 1 - {SMALLEST_LOSS:g})"
        )
    sweep = Sweep(device, scenario.sweep.parameter, scenario.sweep.from_, scenario.sweep.to) if scenario.sweep else None
    if sweep is not None:
        unresolved = sweep.unresolved
    else:
        unresolved = device.too_short("length_m", device.length_m) or device.too_light("length_m", device.length_m)
    if unresolved:
        raise NumericalError(unresolved)
    solution = solve(sweep) if sweep is not None else None
    design = design_point(device, sweep.parameter if sweep else None, solution) if steps.runs("design") else None
    study = Study(
        loaded=loaded,
        plan=steps,
        device=device,
        sweep=sweep,
        solution=solution,
        table=table(solution) if solution else (),
        stable_ranges=stable_ranges(solution) if solution else (),
        design=design,
        membrane=None,
        voltages=(),
        design_voltages=None,
    )
    mass = scenario.device.ball_mass_kg
    if mass is not None:
        study = _with_energy(study, mass)
    if scenario.simulation is not None:
        study = _with_simulation(study, scenario.simulation, progress)
    if scenario.accuracy is not None:
        study = _with_accuracy(study, scenario.accuracy, progress)
    return study if scenario.requirements is None else _with_criteria(study)


def _with_simulation(study: Study, asked: blocks.Simulation, progress: Progress | None) -> Study:
    from vireport.trust.crosscheck import crosscheck

    motions = study.design.motions if study.design is not None else None
    return replace(study, crosscheck=crosscheck(study.device, study.sweep, study.solution, motions, asked, progress))


def _with_accuracy(study: Study, asked: blocks.Accuracy, progress: Progress | None) -> Study:
    from vireport.trust.workprecision import measure

    study = replace(study, work=measure(study, asked.repeats, progress))
    if not study.plan.runs("compliant"):
        return study
    from vireport.trust.stiffness import compliance

    return replace(study, compliance=compliance(study, asked.ladder, asked.repeats, progress))


def with_certificates(study: Study) -> Study:
    """Add proven enclosures of the critical points, from ball arithmetic.

    Raises
    ------
    NumericalError
        If the package for it is not installed.
    """
    from vireport.analysis.certify import certify

    return replace(study, certificates=certify(study))


def _with_criteria(study: Study) -> Study:
    from vireport.gate.requirements import assess

    return replace(study, criteria=assess(study))


def _with_energy(study: Study, mass: float) -> Study:
    scenario, device = study.scenario, study.device
    given = scenario.device.membrane or blocks.Membrane()
    membrane = Membrane(**{name: getattr(given, name) for name in Membrane.__slots__})
    parameter = study.sweep.parameter if study.sweep else "length_m"

    def of(motions: Motions) -> Voltages:
        return voltages(*impact_velocities(device, parameter, motions), mass, membrane)

    branches = study.solution.branches if study.solution else ()
    return replace(
        study,
        membrane=membrane,
        voltages=tuple(of(branch.motions) for branch in branches),
        design_voltages=of(study.design.motions) if study.design else None,
    )
