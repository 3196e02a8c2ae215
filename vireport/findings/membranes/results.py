"""Records of results.json and accuracy.json on the motion with compliant membranes."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.design.compliant.descent import Rigid
from vireport.findings.membranes.compliance import (
    Compliance,
    Convergence,
    Grade,
    ModelCriterion,
    StiffnessRung,
    Volts,
)
from vireport.findings.membranes.solvers import SolverRun
from vireport.scenario.parameters import Parameter


class ComplianceData(ResultsBlock, frozen=True, kw_only=True):
    """The compliant motion beside the rigid one, and every run of a solver.

    Attributes
    ----------
    nothing
        why there is nothing to compare; else null
    grade
        how good the rigid model is: 0 good enough, 1 to be used with care, 2 not good enough; null where nothing is
        compared
    rigid
        the motion with rigid impacts; null where there is none
    varied, design_value
        the parameter that varies towards the critical point that is followed, and its value where the motion is
    order : 1
        1/(h + 1), the rate by which everything is expected to approach the rigid model
    rungs
        the motion on each stiffness, softest first
    convergence
        how quantities approach their rigid values
    volts
        mean voltage; null where the motion is lost
    runs
        each solver with each setting on each rung
    error_bounds : F π/(M ω), rad
        estimate of the error of velocity and phase on each rung; null where the motion is lost
    criteria
        what the rigid model is judged by
    """

    nothing: str | None
    grade: Grade | None
    rigid: Rigid | None
    varied: Parameter
    design_value: float
    order: float
    rungs: tuple[StiffnessRung, ...]
    convergence: tuple[Convergence, ...]
    volts: Volts | None
    runs: tuple[SolverRun, ...]
    error_bounds: tuple[float | None, ...]
    criteria: tuple[ModelCriterion, ...]


def compliance_data(comparison: Compliance) -> ComplianceData:
    """The record of the compliant motion, of the rigid one, and of every run of a solver."""
    return ComplianceData(
        nothing=comparison.reason or None,
        grade=comparison.grade,
        rigid=comparison.rigid,
        varied=comparison.varied,
        design_value=comparison.design_value,
        order=comparison.order,
        rungs=comparison.rungs,
        convergence=comparison.convergence,
        volts=comparison.volts,
        runs=comparison.runs,
        error_bounds=tuple(None if rung.orbit is None else rung.orbit.error for rung in comparison.rungs),
        criteria=comparison.criteria,
    )
