"""The blocks of a scenario: which keys exist, what they mean, and the range of each.

This is the one place where a key is defined. The validator at the end of the module, the JSON Schema, the
wording of mistakes and the commented template are all derived from it or checked against it. Nothing here
reads a file, and nothing knows what is computed.
"""

# Without `from __future__ import annotations`: the annotations below are read, so they must not be text.

from dataclasses import dataclass
from typing import Annotated, Literal

from vireport.scenario.keys import Key, validator
from vireport.scenario.parameters import Parameter

# The dimensionless groups are products of up to six of the quantities, e.g. d = s M omega^2/(pi^2 F), and the
# theory squares and cubes them. With every quantity in this range those products stay clear of 1e-308 and
# 1e308, where double precision ends; the range itself is wider than that of anything built, from MEMS to wave
# power.
SMALLEST, LARGEST = 1e-15, 1e15
LONGEST_TITLE = 200
LARGEST_PERIOD_RATIO = 20
WIDEST_MARGIN = 75.0  # per cent: as far as is looked from a design point without a sweep, and no further

_SWEPT = "Required unless it is swept; with a sweep over it, it is the design point."

SweepParameter = Literal["length_m", "amplitude_n", "frequency_hz", "inclination_deg"]

SWEEPABLE: dict[str, str] = {parameter.value: parameter.path for parameter in Parameter}
"""Where each parameter that can be swept stands in the scenario."""


def _positive(title: str, unit: str, meaning: str, example: float) -> Key:
    return Key(title, unit, meaning, example, ge=SMALLEST, le=LARGEST)


def _percent(title: str, kind: str) -> Key:
    meaning = f"Least distance from the design point to the nearest {kind} that ends stable motion, over its value."
    return Key(title, "%", meaning, 5.0, gt=0.0, le=WIDEST_MARGIN)


@dataclass(frozen=True, slots=True, kw_only=True)
class Membrane:
    """The dielectric elastomer membrane at either end of the capsule, Eqs. (5.2)-(5.5)."""

    stiffness: Annotated[
        float,
        _positive("Stiffness", "N/m^h", "Coefficient K of the membrane's restoring force K delta^h.", 4.0847e5),
    ] = 4.0847e5
    exponent: Annotated[
        float, Key("Exponent", "1", "Exponent h of the restoring force K delta^h.", 2.6, gt=0.0, le=20.0)
    ] = 2.6
    active_radius_m: Annotated[
        float, _positive("Active radius", "m", "Radius Rc of the membrane's active area.", 6.3e-3)
    ] = 6.3e-3
    ball_radius_m: Annotated[
        float, _positive("Ball radius", "m", "Radius rb of the ball; smaller than active_radius_m.", 5.0e-3)
    ] = 5.0e-3
    bias_voltage_v: Annotated[
        float, _positive("Bias voltage", "V", "Voltage Uin applied to the undeformed membrane.", 2000.0)
    ] = 2000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """The capsule, the ball in it, and the membranes that close it."""

    capsule_mass_kg: Annotated[float, _positive("Capsule mass", "kg", "Mass M of the capsule.", 0.1245)]
    ball_mass_kg: Annotated[
        float | None,
        _positive(
            "Ball mass",
            "kg",
            "Mass m of the ball; smaller than capsule_mass_kg. Energy and voltage are evaluated where it is "
            "given, and left out where it is not.",
            0.0041,
        ),
    ] = None
    restitution: Annotated[
        float,
        Key(
            "Restitution",
            "1",
            "Coefficient of restitution r of an impact on a membrane.",
            0.5,
            ge=0.0,
            le=1.0,
        ),
    ]
    length_m: Annotated[float | None, _positive("Length", "m", "Distance s between the membranes. " + _SWEPT, 0.7)] = (
        None
    )
    membrane: Annotated[
        Membrane | None,
        Key(
            "Membrane",
            "",
            "Electrical and elastic data of the membranes. Left out, the defaults hold; needs ball_mass_kg.",
        ),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """The harmonic force on the capsule, F cos(omega t)."""

    amplitude_n: Annotated[
        float | None,
        _positive("Force amplitude", "N", "Amplitude F of the force on the capsule. " + _SWEPT, 3.0),
    ] = None
    frequency_hz: Annotated[
        float | None, _positive("Frequency", "Hz", "Frequency omega/(2 pi) of the force. " + _SWEPT, 2.0)
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """One parameter taken from one value to another; everything else is held."""

    parameter: Annotated[SweepParameter, Key("Swept parameter", "", "The parameter that is varied.", "length_m")]
    from_: Annotated[float, Key("From", "", "First value, in the parameter's unit; it may be the larger.", 0.59)]
    to: Annotated[float, Key("To", "", "Last value, in the parameter's unit; not equal to the first.", 0.75)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The simulation beside the solution: where it is asked for, and from how many starts."""

    samples: Annotated[
        int, Key("Samples", "1", "Values of the swept parameter that are simulated.", 41, ge=2, le=2001)
    ] = 41
    starts: Annotated[
        int, Key("Starts", "1", "Starting states tried at each value, the same in every run.", 4, ge=1, le=64)
    ] = 4
    impacts: Annotated[
        int,
        Key("Impacts", "1", "Impacts from each start; slow transients go on longer.", 1000, ge=100, le=100_000),
    ] = 1000
    tolerance: Annotated[
        float,
        Key(
            "Tolerance",
            "1",
            "Largest difference of velocity and phase up to which simulation and solution agree.",
            1e-9,
            gt=0.0,
            le=1e-3,
        ),
    ] = 1e-9
    diagram: Annotated[
        bool, Key("Diagram", "", "Whether to draw a bifurcation diagram from simulation alone.", True)
    ] = False
    portraits: Annotated[
        tuple[float, ...],
        Key("Portraits", "as the parameter", "Values of the swept parameter for figure 3.", [0.59, 0.69], max_length=8),
    ] = ()
    displacement: Annotated[
        tuple[float, ...],
        Key("Displacement", "as the parameter", "Values of the swept parameter for figure 6.", [0.69], max_length=8),
    ] = ()


_STABLE = "End of the range of the swept parameter over which there must be stable 1:1 motion."
_ANGLES = "End of the range of inclination over which the design must have stable 1:1 motion."


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirements:
    """What the design must meet: each is a line of the acceptance table, and one that fails makes the exit code 1."""

    stable_from: Annotated[float | None, Key("Stable from", "as the parameter", _STABLE, 0.65)] = None
    stable_to: Annotated[float | None, Key("Stable to", "as the parameter", _STABLE, 0.75)] = None
    inclination_from_deg: Annotated[float | None, Key("Inclination from", "deg", _ANGLES, 40.0, ge=0.0, le=90.0)] = None
    inclination_to_deg: Annotated[float | None, Key("Inclination to", "deg", _ANGLES, 50.0, ge=0.0, le=90.0)] = None
    margin_period_doubling_percent: Annotated[
        float | None, _percent("Margin to period doubling", "period doubling")
    ] = None
    margin_grazing_percent: Annotated[float | None, _percent("Margin to grazing", "grazing point")] = None
    margin_any_percent: Annotated[float | None, _percent("Margin", "critical point of any kind")] = None
    u_ave_at_least_v: Annotated[
        float | None, _positive("U_ave at least", "V", "Least U_ave of the stable motions at the design point.", 1000.0)
    ] = None
    u_ave_difference_at_most_v: Annotated[
        float | None,
        _positive("U_ave difference", "V", "Largest less least U_ave over the stable range that is required.", 5000.0),
    ] = None
    u_bottom_top_difference_at_most_v: Annotated[
        float | None,
        _positive("Bottom to top", "V", "Largest voltage between either end at the design point.", 30000.0),
    ] = None
    deflection_at_most_m: Annotated[
        float | None,
        _positive("Deflection at most", "m", "Largest deflection of a membrane at the design point.", 0.02),
    ] = None
    crosscheck_passed: Annotated[
        bool | None, Key("Cross-check", "", "Whether the simulation must agree with the solution.", True)
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """Error against run time of several methods, and the motion with compliant membranes beside the rigid one."""

    repeats: Annotated[
        int, Key("Repeats", "1", "Runs of each method, of which the median time counts.", 5, ge=1, le=100)
    ] = 5
    compliant_membrane: Annotated[
        bool, Key("Compliant membrane", "", "Whether to solve the motion with the membrane's own stiffness too.", True)
    ] = True
    ladder: Annotated[
        tuple[float, ...],
        Key(
            "Ladder",
            "1",
            "Factors on the membrane's stiffness, ascending from 1.",
            [1.0, 1e4],
            min_length=2,
            max_length=8,
        ),
    ] = (1.0, 1e2, 1e4, 1e6, 1e8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A vibro-impact energy harvester, its excitation, and what is varied."""

    schema_version: Annotated[int, Key("Schema version", "", "Version of this format; 1.", 1, ge=1, le=1)]
    title: Annotated[
        str | None,
        Key(
            "Title",
            "",
            "Free text of one line for the head of the report.",
            "Inclined harvester",
            min_length=1,
            max_length=LONGEST_TITLE,
        ),
    ] = None
    device: Annotated[Device, Key("Device", "", "The capsule, the ball in it, and the membranes.")]
    excitation: Annotated[Excitation, Key("Excitation", "", "The harmonic force on the capsule.")]
    inclination_deg: Annotated[
        float | None,
        Key(
            "Inclination",
            "deg",
            "Angle beta of the capsule to the horizontal. " + _SWEPT,
            45.0,
            ge=0.0,
            le=90.0,
        ),
    ] = None
    gravity_m_s2: Annotated[float, _positive("Gravity", "m/s^2", "Gravitational acceleration g.", 9.8)] = 9.8
    period_ratio: Annotated[
        int,
        Key(
            "Period ratio",
            "1",
            "Forcing periods n that one period of the motion takes, Eq. (3.14).",
            1,
            ge=1,
            le=LARGEST_PERIOD_RATIO,
        ),
    ] = 1
    sweep: Annotated[
        Sweep | None,
        Key("Sweep", "", "The parameter that is varied. Left out, the design point alone is evaluated."),
    ] = None
    simulation: Annotated[
        Simulation | None,
        Key("Simulation", "", "The simulation beside the solution. Left out, nothing is simulated."),
    ] = None
    accuracy: Annotated[
        Accuracy | None,
        Key("Accuracy", "", "Error against run time, and the compliant membrane. Left out, neither is measured."),
    ] = None
    requirements: Annotated[
        Requirements | None, Key("Requirements", "", "What the design must meet. Left out, nothing is judged.")
    ] = None


def validated(tree: object) -> Scenario:
    """Make a scenario of a tree as it is read from a file.

    Raises
    ------
    pydantic_core.ValidationError
        With all values that are wrong in themselves, and all keys that are unknown or missing.
    """
    scenario: Scenario = validator(Scenario).validate_python(tree)
    return scenario
