"""Results on tolerances as records of results.json, and the verification of their proof from these alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock
from vireport.findings.tolerances.proof import Proof, prove_again
from vireport.findings.tolerances.region import region_of
from vireport.findings.tolerances.tolerances import Answer, Failure, Tolerances, half_widths
from vireport.physics.device import Device
from vireport.scenario.blocks import Distribution, Scenario
from vireport.scenario.loading import load
from vireport.scenario.parameters import DesignInput
from vireport.scenario.writing import as_yaml, device_tree
from vireport.study.reading import read_record
from vireport.study.results import results_block


class TolerancedInput(ResultsBlock, frozen=True, kw_only=True):
    """An input that has a tolerance.

    Attributes
    ----------
    parameter, unit
        the input, and its unit
    from_, to : `unit`
        its least and largest value
    """

    parameter: DesignInput
    from_: float
    to: float
    unit: str


class ProvedBoxes(ResultsBlock, frozen=True, kw_only=True):
    """The boxes of a proof over tolerances, and a motion in the middle of each that is proved.

    Attributes
    ----------
    halved
        the boxes generation by generation, the lower half of each before the upper one: −1 is proved, −2 undecided,
        another number the factor along which a box is halved (0 M/F, 1 s f², 2 sin β, 3 r)
    u, phi_bottom_rad, velocity_bottom : 1, rad, F π/(M ω)
        q − 1/2, phase and velocity of a motion in the middle of each proved box
    """

    halved: list[int]
    u: list[float]
    phi_bottom_rad: list[float]
    velocity_bottom: list[float]


class WorstDevice(ResultsBlock, frozen=True, kw_only=True):
    """Of the devices that fail, the one towards which stable motion ends first.

    Attributes
    ----------
    values
        of the inputs
    share : 1
        share of the distance from the design to it at which stable motion ends
    scenario
        the device, as YAML
    """

    values: dict[str, float]
    share: float
    scenario: str


class YieldData(ResultsBlock, frozen=True, kw_only=True):
    """How many of some random devices have a stable 1:1 motion.

    Attributes
    ----------
    distribution
        of the inputs within their tolerances
    samples, stable
        number of random devices, and how many have stable motion
    share, low_95, high_95 : 1
        their share, and its 95 % interval
    """

    distribution: Distribution
    samples: int
    stable: int
    share: float
    low_95: float
    high_95: float


class PercentilesData(ResultsBlock, frozen=True, kw_only=True):
    """Percentiles of a number over the stable motions of random devices.

    Attributes
    ----------
    least, percentile_5, median, percentile_95, largest
        percentiles
    """

    least: float
    percentile_5: float
    median: float
    percentile_95: float
    largest: float


class TolerancesData(ResultsBlock, frozen=True, kw_only=True):
    """Whether every device within the tolerances has stable motion, and how many have.

    Attributes
    ----------
    answer
        `proved`, `refuted` or `undecided`
    inputs
        those that have a tolerance
    boxes
        number of proved boxes
    open_share : 1
        share of the volume in (d, gbar, r) that is neither proved nor refuted; null where a device fails, or no proof
        is available
    proof
        the boxes; null where the design or a corner fails, so that no proof was attempted, or none is available
    proof_not_known_of
        `excitation.harmonics` if the force has harmonics, for which no proof is available; else null
    worst
        the worst device; null where none fails
    yield_
        how many of some random devices have stable motion
    ranges
        of `velocity_bottom_m_s`, `velocity_top_m_s` and, where energy is evaluated, `u_ave_v` over the stable motions
        of these devices; empty where there are none
    """

    answer: Answer
    inputs: list[TolerancedInput]
    boxes: int
    open_share: float | None
    proof: ProvedBoxes | None
    proof_not_known_of: str | None
    worst: WorstDevice | None
    yield_: YieldData
    ranges: dict[str, PercentilesData]


def tolerances_data(tolerances: Tolerances, scenario: Scenario) -> TolerancesData:
    """The record of tolerances, with the worst device as a scenario too."""
    sampled, proof, worst = tolerances.sampled, tolerances.proof, tolerances.worst
    return TolerancesData(
        answer=tolerances.answer,
        inputs=[
            TolerancedInput(parameter=varied, from_=low, to=high, unit=varied.unit)
            for varied, (low, high) in tolerances.region.ranges.items()
        ],
        boxes=0 if proof is None else proof.boxes,
        open_share=None if proof is None or worst is not None else proof.open_share,
        proof=None if proof is None else _boxes(proof),
        proof_not_known_of=None if tolerances.provable else "excitation.harmonics",
        worst=None
        if worst is None
        else WorstDevice(
            values={str(varied): value for varied, value in worst.values.items()},
            share=worst.share,
            scenario=worst_scenario(scenario, worst),
        ),
        yield_=YieldData(
            distribution=sampled.distribution,
            samples=sampled.samples,
            stable=sampled.stable,
            share=sampled.stable / sampled.samples,
            low_95=sampled.low,
            high_95=sampled.high,
        ),
        ranges={name: PercentilesData(**of) for name, of in tolerances.ranges.items()},
    )


def _boxes(proof: Proof) -> ProvedBoxes:
    u, phase, velocity = proof.motions.tolist()
    return ProvedBoxes(halved=proof.halved.tolist(), u=u, phi_bottom_rad=phase, velocity_bottom=velocity)


def worst_scenario(scenario: Scenario, worst: Failure) -> str:
    """A scenario of the failing device, as YAML: its inputs, without the outputs and requirements of the design."""
    return as_yaml(device_tree(scenario, {varied.path: value for varied, value in worst.values.items()}))


def recheck(data: Mapping[str, object]) -> float:
    """Verify the proof that every device within the tolerances has stable motion, from results alone.

    Parameters
    ----------
    data : mapping
        Content of a results.json.

    Returns
    -------
    float
        Share of the volume in (d, gbar, r) that is proved [1]; 1 if that is every device within the tolerances.

    Raises
    ------
    UsageError
        If the results have no proof, or not all of its boxes.
    """
    recorded = results_block(data, "tolerances").get("proof")
    scenario = load(results_block(data, "scenario")).scenario
    if scenario.tolerances is None or recorded is None:
        raise UsageError("these results have no proof over tolerances (allowed: those of a scenario with tolerances)")
    proof = read_record(recorded, ProvedBoxes, "results", "tolerances.proof")
    device = Device.of(scenario)
    try:
        boxes = np.array(proof.halved, dtype=np.intp), np.array([proof.u, proof.phi_bottom_rad, proof.velocity_bottom])
        return prove_again(region_of(device, half_widths(device, scenario.tolerances)), *boxes)
    except ValueError as error:
        raise UsageError(f"tolerances.proof: {error}") from error
