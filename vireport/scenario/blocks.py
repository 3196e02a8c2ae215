"""The blocks of a scenario and of a map file: which keys exist, what they mean, and the range of each.

This is the one place where a key is declared. Validation, the JSON Schema, the wording of mistakes and the report's
table of inputs are derived from it. Nothing here reads a file, and nothing knows what is computed.
"""
# Annotations are evaluated where they stand: as texts, pydantic compiled each of 200, a quarter of this import.

from collections.abc import Iterator
from enum import IntEnum, StrEnum
from functools import cache, partial
from typing import Annotated, Any, NamedTuple, Self, get_args, get_origin

from pydantic import AfterValidator, Field, PlainValidator, WithJsonSchema, model_validator
from pydantic.fields import FieldInfo

from vireport.base.additions import ADDITIONS
from vireport.scenario.demands import AGREEMENT, AT_LEAST, AT_MOST, HELD, RANGE, WORDS, Demand, Need
from vireport.scenario.keys import (
    REQUIRED,
    Block,
    WhenGiven,
    declared_with,
    key,
    positive,
    with_added_keys,
)
from vireport.scenario.parameters import LARGEST, SMALLEST, DesignInput, Parameter
from vireport.text.foreign import without_joins

LONGEST_TEXT = 200
LARGEST_PERIOD_RATIO = 20
LARGEST_EXPONENT = 20.0  # of a membrane's force
WIDEST_MARGIN = 75.0  # per cent: as far as is looked from a design point without a sweep, and no further
WIDEST_TOLERANCE = 50.0  # per cent
MOST_VARIED = 4
MOST_EFFECTS = 16

UNITS = {"1": "", "deg": "°", "m/s^2": "m/s²", "N/m^h": "N/mʰ"}
"""Units of keys that pages print in another way, by the unit as declared."""

UNIT_OF_SWEPT = "the unit of the swept parameter"
"""The unit, in a declaration, of a value of the parameter that is swept."""


UNIT_OF_VARIED = "the unit of the input"
"""The unit, in a declaration, of a value of an input that may vary."""


STEEPEST_RESTITUTION = -0.5
"""Least exponent with which a restitution falls with speed; -0.25 to 0 is usual for metals and polymers."""

FLATTEST_RESTITUTION = -0.001
"""Largest exponent of a restitution that falls with speed as an effect that is tried."""

SLOWEST_STATED, FASTEST_STATED = 1e-3, 1e3
"""Least and largest speed of an impact at which a restitution can be stated [m/s]."""

LARGEST_EFFECT = 50.0
"""Largest size of an effect that is tried [%]."""


def is_printable(text: str) -> bool:
    """Whether a text is one line that any output can show: not blank, and without control characters."""
    return without_joins(text).isprintable() and bool(text.strip())


def _printable(text: str) -> str:
    if not is_printable(text):
        raise ValueError("not printable")
    return text


TEXT = Annotated[str, Field(min_length=1, max_length=LONGEST_TEXT), AfterValidator(_printable)]
"""Free text of one printable line, which can do no harm on terminals, in logs and on pages."""


def _dielectric(title: str, unit: str, meaning: str, example: float) -> Any:
    needs = "For energy, power and field; with the other two of thickness, permittivity and breakdown field."
    return positive(None, title, unit, f"{meaning} {needs}", example=example)


def _restitution(title: str, meaning: str, example: float) -> Any:
    return key(None, title, "1", meaning, example=example, ge=0.0, le=1.0)


def _swept(parameter: Parameter, title: str, unit: str, meaning: str, example: float) -> Any:
    low, high = parameter.limits
    unless = "Required unless it is swept; with a sweep over it, it is the design point."
    return key(None, title, unit, f"{meaning} {unless}", example=example, ge=low, le=high)


class MembraneBlock(Block):
    """The dielectric elastomer membrane at either end of the capsule, Eqs. (5.2)-(5.5)."""

    stiffness: float = positive(
        4.0847e5, "Stiffness", "N/m^h", "Coefficient K of the membrane's restoring force K delta^h."
    )
    exponent: float = key(
        2.6, "Exponent", "1", "Exponent h of the restoring force K delta^h.", gt=0.0, le=LARGEST_EXPONENT
    )
    active_radius_m: float = positive(6.3e-3, "Active radius", "m", "Radius Rc of the membrane's active area.")
    ball_radius_m: float = positive(5.0e-3, "Ball radius", "m", "Radius rb of the ball; smaller than active_radius_m.")
    bias_voltage_v: float = positive(2000.0, "Bias voltage", "V", "Voltage Uin applied to the undeformed membrane.")
    thickness_m: float | None = _dielectric("Thickness", "m", "Thickness of the undeformed membrane.", 1e-3)
    relative_permittivity: float | None = _dielectric(
        "Relative permittivity", "1", "Permittivity of the membrane over that of vacuum.", 4.7
    )
    breakdown_field_v_m: float | None = _dielectric(
        "Breakdown field", "V/m", "Electric field that the membrane withstands.", 1e8
    )


class CapsuleMotion(StrEnum):
    """What moves the capsule, and whether it feels the ball."""

    PRESCRIBED = "prescribed"
    FREE = "free"


LARGEST_FRICTION = 2.0
"""Largest coefficient of dry friction, beyond that of any pair of materials of a ball and a capsule."""


class DeviceBlock(Block):
    """The capsule, the ball in it, and the membranes that close it."""

    capsule_mass_kg: float = positive(REQUIRED, "Capsule mass", "kg", "Mass M of the capsule.", example=0.1245)
    ball_mass_kg: float | None = positive(
        None,
        "Ball mass",
        "kg",
        "Mass m of the ball; smaller than capsule_mass_kg. Energy and voltage are evaluated where it is given, and "
        "left out where it is not. Needed where the capsule is free.",
        example=0.0041,
    )
    capsule: CapsuleMotion = key(
        CapsuleMotion.PRESCRIBED,
        "Capsule",
        "",
        "Whether the shaker imposes the capsule's motion (prescribed), or the force drives it and it recoils from the "
        "ball (free).",
        strict=False,
    )
    friction: float = key(
        0.0,
        "Friction",
        "1",
        "Coefficient of dry friction between the ball and the capsule, on which its weight across the capsule presses "
        "it.",
        example=0.05,
        ge=0.0,
        le=LARGEST_FRICTION,
    )
    restitution: float | None = _restitution(
        "Restitution",
        "Coefficient of restitution r of an impact on either membrane. Required unless restitution_bottom and "
        "restitution_top are given.",
        0.5,
    )
    restitution_bottom: float | None = _restitution(
        "Restitution at the bottom", "That of the bottom membrane, with restitution_top instead of restitution.", 0.475
    )
    restitution_top: float | None = _restitution(
        "Restitution at the top", "That of the top membrane, with restitution_bottom instead of restitution.", 0.525
    )
    restitution_exponent: float = key(
        0.0,
        "Restitution exponent",
        "1",
        "Exponent with which the restitution of either membrane falls with the speed of the impact: "
        "r (speed/restitution_speed_m_s)^exponent.",
        example=-0.1,
        ge=STEEPEST_RESTITUTION,
        le=0.0,
    )
    restitution_speed_m_s: float | None = key(
        None,
        "Restitution speed",
        "m/s",
        "Speed of the impact at which the restitution is as given. Required with restitution_exponent.",
        example=5.0,
        ge=SLOWEST_STATED,
        le=FASTEST_STATED,
    )
    length_m: float | None = _swept(Parameter.LENGTH, "Length", "m", "Distance s between the membranes.", 0.7)
    membrane: MembraneBlock | None = key(
        None,
        "Membrane",
        "",
        "Electrical and elastic data of the membranes. Left out, the defaults hold; needs ball_mass_kg.",
    )

    @property
    def alike(self) -> bool:
        """Whether both membranes have one restitution."""
        return self.restitution_bottom == self.restitution_top

    @model_validator(mode="before")
    @classmethod
    def _with_membrane(cls, tree: object) -> object:
        """Fill in the default membrane where energy is evaluated: where the ball's mass is given."""
        if isinstance(tree, dict) and tree.get("ball_mass_kg") is not None and tree.get("membrane") is None:
            return tree | {"membrane": {}}
        return tree


LARGEST_HARMONIC = 50.0
"""Largest amplitude of a harmonic over that of the force [%], also in the search for where stable motion ends."""

HIGHEST_ORDER = 8
"""Order of the highest harmonic of a force."""


class HarmonicBlock(Block):
    """A harmonic of the force, F percent/100 cos(order x + phase) where the sine is F cos x."""

    order: int = key(REQUIRED, "Order", "1", "Order of the harmonic.", example=2, ge=2, le=HIGHEST_ORDER)
    percent: float = key(
        REQUIRED, "Size", "%", "Amplitude over that of the force.", example=5.0, ge=0.0, le=LARGEST_HARMONIC
    )
    phase_deg: float = key(
        REQUIRED, "Phase", "deg", "Phase where that of the sine is 0.", example=225.0, ge=-360.0, le=360.0
    )

    def __str__(self) -> str:
        """The harmonic as a factor of F."""
        return f"{self.percent:.12g} %, order {self.order}, {self.phase_deg:.12g} deg"


class ExcitationBlock(Block):
    """The periodic force on the capsule, F cos(omega t) and its harmonics."""

    amplitude_n: float | None = _swept(
        Parameter.AMPLITUDE, "Force amplitude", "N", "Amplitude F of the force on the capsule.", 3.0
    )
    frequency_hz: float | None = _swept(
        Parameter.FREQUENCY, "Frequency", "Hz", "Frequency omega/(2 pi) of the force.", 2.0
    )
    harmonics: tuple[WhenGiven[HarmonicBlock], ...] = key(
        (),
        "Harmonics",
        "",
        "Harmonics of the force, each order once. Left out, it is a sine.",
        example=[{"order": 2, "percent": 5.0, "phase_deg": 225.0}],
        max_length=HIGHEST_ORDER - 1,
        strict=False,
    )
    record: TEXT | None = key(
        None,
        "Record",
        "",
        "File with the capsule's acceleration as it was measured, which is driven through the device: its path from "
        "the folder of the scenario.",
        addition="driven",
        example="shaker.csv",
    )

    @property
    def distorted(self) -> bool:
        """Whether the force is no sine."""
        return any(harmonic.percent for harmonic in self.harmonics)


class SweepBlock(Block):
    """One parameter taken from one value to another; everything else is held."""

    parameter: Parameter = key(
        REQUIRED,
        "Swept parameter",
        "",
        "The parameter that is varied. Of restitution, that of both membranes, their difference is kept; that of one "
        "alone leaves the other's as the device has it.",
        example="length_m",
        strict=False,
    )
    from_: float = key(
        REQUIRED, "From", UNIT_OF_SWEPT, "First value; it may be the larger.", example=0.59, alias="from"
    )
    to: float = key(REQUIRED, "To", UNIT_OF_SWEPT, "Last value; not equal to the first.", example=0.75)


class Direction(StrEnum):
    """Direction of a slow sweep, in which each value starts from the state that the last one ended in."""

    NONE = "none"
    UP = "up"
    DOWN = "down"
    BOTH = "both"


class SimulationBlock(Block):
    """The simulation beside the solution: where it is asked for, and from how many starts."""

    samples: int = key(41, "Samples", "1", "Values of the swept parameter that are simulated.", ge=2, le=2001)
    starts: int = key(
        4, "Starts", "1", "Random starts at each value, of its own and the same in every run.", ge=1, le=64
    )
    impacts: int = key(
        1000, "Impacts", "1", "Impacts from each start; slow transients go on longer.", ge=100, le=100_000
    )
    tolerance: float = key(
        1e-9,
        "Tolerance",
        "1",
        "Largest difference of velocity and phase up to which simulation and solution agree.",
        gt=0.0,
        le=1e-3,
    )
    diagram: bool = key(
        False, "Diagram", "", "Whether to draw a bifurcation diagram from simulation alone.", example=True
    )
    follow: Direction = key(
        Direction.NONE,
        "Follow",
        "",
        "Direction in which the sweep is gone through slowly, each value from the state that the last one ended in: "
        "up, down, or both, one after the other.",
        strict=False,
    )
    # Lists become tuples as they are read, which strictly no list is.
    portraits: tuple[float, ...] = key(
        (),
        "Portraits",
        UNIT_OF_SWEPT,
        "Values of the swept parameter for phase portraits and time series (figure-3).",
        example=[0.59, 0.69],
        max_length=8,
        strict=False,
    )
    displacement: tuple[float, ...] = key(
        (),
        "Displacement",
        UNIT_OF_SWEPT,
        "Values of the swept parameter for the displacement of capsule and ball (figure-6).",
        example=[0.69],
        max_length=8,
        strict=False,
    )


_STABLE_RANGE = Demand(RANGE, (Need.SWEEP,), at_design=False)
_INCLINATIONS = Demand(RANGE, over=Parameter.INCLINATION)
_MOTIONS = Demand(WORDS, (Need.SWEEP,))


def _stable(title: str, example: float) -> Any:
    meaning = "End of the range of the swept parameter over which there must be stable 1:1 motion."
    return key(None, title, UNIT_OF_SWEPT, meaning, example=example)


def _angle(title: str, example: float) -> Any:
    meaning = "End of the range of inclination over which the design must have stable 1:1 motion."
    low, high = Parameter.INCLINATION.limits
    return key(None, title, "deg", meaning, example=example, ge=low, le=high)


def _percent(title: str, kind: str) -> Any:
    meaning = (
        f"Least distance from the design point to the nearest {kind} that ends one of its stable motions, in whichever "
        "of length, force, capsule mass, frequency, inclination and restitution, of both membranes together and of "
        "either alone, it is nearest, over the design value."
    )
    return key(None, title, "%", meaning, example=5.0, gt=0.0, le=WIDEST_MARGIN)


MOST_EFFICIENT = 100.0
"""Largest share of the energy lost in impacts that can become electrical [%]."""

LONGEST_WORD = 16
WORD = Annotated[str, Field(pattern="^[BT]+$", max_length=LONGEST_WORD, strict=True)]
"""Impacts of one period in their order, B on the bottom and T on the top."""


_FROM_REST = Demand(HELD)


@partial(with_added_keys, within="requirements")
class RequirementsBlock(Block):
    """What the design must meet: each is a line of the acceptance table, and one that fails makes the exit code 1."""

    stable_from: Annotated[float | None, _STABLE_RANGE] = _stable("Stable from", 0.65)
    stable_to: Annotated[float | None, _STABLE_RANGE] = _stable("Stable to", 0.75)
    inclination_from_deg: Annotated[float | None, _INCLINATIONS] = _angle("Inclination from", 40.0)
    inclination_to_deg: Annotated[float | None, _INCLINATIONS] = _angle("Inclination to", 50.0)
    margin_period_doubling_percent: Annotated[float | None, Demand(AT_LEAST)] = _percent(
        "Margin to period doubling", "period doubling"
    )
    margin_grazing_percent: Annotated[float | None, Demand(AT_LEAST)] = _percent("Margin to grazing", "grazing point")
    margin_any_percent: Annotated[float | None, Demand(AT_LEAST)] = _percent("Margin", "critical point of any kind")
    word: Annotated[WORD | None, _MOTIONS] = key(
        None,
        "Word",
        "",
        "Impacts of one period, B on the bottom and T on the top, of every motion that may be stable at the design "
        "point; one must be.",
        example="BT",
    )
    words: Annotated[tuple[WORD, ...] | None, _MOTIONS] = key(
        None,
        "Words",
        "",
        "The same of further motions that may be stable.",
        example=["BT", "BBT"],
        min_length=1,
        max_length=8,
        strict=False,
    )
    reached_from_rest: Annotated[bool | None, _FROM_REST] = key(
        None,
        "Reached from rest",
        "",
        "Whether the device must reach a stable motion that is required, or else 1:1 motion, when it is switched on. A "
        "search for the best design requires it unless this is false or a word is required, which it must reach.",
        example=True,
    )
    recovers_within_periods: Annotated[float | None, Demand(AT_MOST)] = positive(
        None,
        "Recovers within",
        "periods",
        "Most forcing periods until 1 % is left of a small disturbance of the slowest stable 1:1 motion at the design "
        "point.",
        example=40.0,
    )
    margin_with_effects_percent: Annotated[float | None, Demand(AT_LEAST)] = key(
        None,
        "Margin with effects",
        "%",
        "The same least distance to the end of any kind, with each of the effects that the model leaves out in turn: "
        "those of effects, or else the usual ones.",
        example=2.0,
        gt=0.0,
        le=WIDEST_MARGIN,
    )
    withstands_distortion_percent: Annotated[float | None, Demand(AT_LEAST)] = key(
        None,
        "Withstands a distortion of",
        "%",
        "Least second or third harmonic of the force, over its amplitude and at its worst phase, that ends a stable "
        "1:1 motion at the design point.",
        example=3.0,
        gt=0.0,
        le=LARGEST_HARMONIC,
    )
    u_ave_at_least_v: Annotated[float | None, Demand(AT_LEAST, (Need.BALL_MASS,))] = positive(
        None, "U_ave at least", "V", "Least U_ave of the stable motions at the design point.", example=1000.0
    )
    u_ave_difference_at_most_v: Annotated[
        float | None, Demand(AT_MOST, (Need.SWEEP, Need.BALL_MASS), at_design=False)
    ] = positive(
        None,
        "U_ave difference",
        "V",
        "Largest less least U_ave over the stable range that is required.",
        example=5000.0,
    )
    u_bottom_top_difference_at_most_v: Annotated[float | None, Demand(AT_MOST, (Need.BALL_MASS,))] = positive(
        None, "Bottom to top", "V", "Largest voltage between either end at the design point.", example=30000.0
    )
    deflection_at_most_m: Annotated[float | None, Demand(AT_MOST, (Need.BALL_MASS,))] = positive(
        None, "Deflection at most", "m", "Largest deflection of a membrane at the design point.", example=0.02
    )
    deflection_at_most_percent: Annotated[float | None, Demand(AT_MOST, (Need.BALL_MASS,))] = positive(
        None,
        "Deflection over radius at most",
        "%",
        "Largest deflection of a membrane at the design point, over its active radius.",
        example=300.0,
    )
    area_ratio_at_most: Annotated[float | None, Demand(AT_MOST, (Need.BALL_MASS,))] = positive(
        None,
        "Area ratio at most",
        "times",
        "Largest area of a membrane at the design point, at its deepest deflection, over that when it is flat; 5.9 is "
        "an areal strain that has been demonstrated.",
        example=5.9,
    )
    power_at_least_mw: Annotated[float | None, Demand(AT_LEAST, (Need.DIELECTRIC,))] = positive(
        None,
        "Power at least",
        "mW",
        "Least mean electrical power of the stable motions at the design point.",
        example=1,
    )
    efficiency_at_most_percent: Annotated[float | None, Demand(AT_MOST, (Need.DIELECTRIC,), usual=MOST_EFFICIENT)] = (
        positive(
            None,
            "Efficiency at most",
            "%",
            "Most electrical energy of the stable motions at the design point, over what their impacts lose by the "
            f"restitution. {MOST_EFFICIENT:.0f} unless it is given, beside other requirements where the energy is "
            "evaluated, and in a search for the best design.",
            example=MOST_EFFICIENT,
        )
    )
    field_at_most_percent: Annotated[float | None, Demand(AT_MOST, (Need.DIELECTRIC,))] = positive(
        None,
        "Field at most",
        "%",
        "Highest electric field in a membrane at the design point, over its breakdown field. A search for the best "
        "design takes 100 unless it is given.",
        example=50.0,
    )
    acceleration_at_most_g: Annotated[float | None, Demand(AT_MOST, at_design=False)] = positive(
        None,
        "Acceleration at most",
        "g",
        "Largest amplitude of the capsule's acceleration over 9.80665 m/s^2 (F/M of a prescribed motion), at the "
        "design point or, without one, over the sweep.",
        example=3.0,
    )
    stroke_at_most_m: Annotated[float | None, Demand(AT_MOST, at_design=False)] = positive(
        None,
        "Stroke at most",
        "m",
        "Largest displacement of the capsule from end to end (2 F/(M omega^2) of a prescribed motion), at the "
        "design point or, without one, over the sweep.",
        example=0.4,
    )
    force_at_most_n: Annotated[float | None, Demand(AT_MOST, at_design=False)] = positive(
        None,
        "Force at most",
        "N",
        "Largest amplitude of the force on the capsule, F, at the design point or, without one, over the sweep.",
        example=5.0,
    )
    crosscheck_passed: Annotated[bool | None, Demand(AGREEMENT, (Need.SIMULATION,), at_design=False)] = key(
        None, "Cross-check", "", "Whether the simulation must agree with the solution.", example=True
    )

    @property
    def allowed(self) -> tuple[str, ...]:
        """Words of the motions that may be stable; () where no motion is required."""
        return (*((self.word,) if self.word is not None else ()), *(self.words or ()))


def _demands() -> dict[Demand, tuple[str, ...]]:
    """All requirements with their keys, in the order of the keys."""
    keys: dict[Demand, tuple[str, ...]] = {}
    for name, field in RequirementsBlock.model_fields.items():
        (demand,) = (part for part in field.metadata if isinstance(part, Demand))
        keys[demand] = (*keys.get(demand, ()), name)
    return keys


DEMANDS = _demands()
"""Every requirement, with its keys."""


MotionName = Annotated[
    str, Field(pattern=r"^([BT]{1,16}|[BCG][1-9][0-9]{0,3})$", description="a word such as BBT, or a label such as B1")
]


_TOO_MANY = "sequences double with each impact, to 4116 of sixteen"


class StartBlock(Block):
    """Motions of a word at a value of the sweep, from which families are followed."""

    word: WORD = key(
        REQUIRED, "Word", "", "The impacts of one period, B on the bottom and T on the top.", example="BBT"
    )
    value: float = key(REQUIRED, "Value", UNIT_OF_SWEPT, "Where along the sweep it is looked for.", example=0.65)
    periods: int = key(1, "Periods", "1", "Forcing periods that the motion takes.", ge=1, le=16)


class MotionsBlock(Block):
    """The families of motions with other sequences of impacts than one on each membrane."""

    impacts: int = key(6, "Impacts", "1", "Most impacts in one period of a motion.", ge=1, le=16, beyond=_TOO_MANY)
    periods: int = key(4, "Periods", "1", "Most forcing periods that a motion takes.", ge=1, le=16, beyond=_TOO_MANY)
    portraits: tuple[MotionName, ...] = key(
        (),
        "Portraits of motions",
        "",
        "Motions that are drawn in full: a word, or the label of a point where families meet.",
        example=["BBT", "B1"],
        max_length=8,
        strict=False,
    )
    starts: tuple[StartBlock, ...] = key(
        (),
        "Starts of families",
        "",
        "Words that are looked for at a value of the sweep, beyond those that are looked for along all of it.",
        example=[{"word": "BBT", "value": 0.65, "periods": 1}],
        max_length=8,
        strict=False,
    )


def _off(varied: DesignInput, most: float = LARGEST) -> Any:
    unit = {"\u00b0": "deg", "": "1"}.get(varied.unit, varied.unit)
    title = f"{varied.quantity.capitalize()} \u00b1"
    return key(None, title, unit, f"Most by which {varied} may be off.", example=0.001, gt=0.0, le=most)


def _off_percent(varied: DesignInput) -> Any:
    title = f"{varied.quantity.capitalize()} \u00b1 per cent"
    return key(None, title, "%", f"The same as a share of {varied}.", example=1.0, gt=0.0, le=WIDEST_TOLERANCE)


class Distribution(StrEnum):
    """Distribution of the inputs of devices within their tolerances."""

    UNIFORM = "uniform"
    NORMAL = "normal"


class TolerancesBlock(Block):
    """The tolerance of each input, in its unit or in per cent; the larger holds where both are given."""

    length_m: float | None = _off(DesignInput.LENGTH)
    length_percent: float | None = _off_percent(DesignInput.LENGTH)
    amplitude_n: float | None = _off(DesignInput.AMPLITUDE)
    amplitude_percent: float | None = _off_percent(DesignInput.AMPLITUDE)
    capsule_mass_kg: float | None = _off(DesignInput.CAPSULE_MASS)
    capsule_mass_percent: float | None = _off_percent(DesignInput.CAPSULE_MASS)
    frequency_hz: float | None = _off(DesignInput.FREQUENCY)
    frequency_percent: float | None = _off_percent(DesignInput.FREQUENCY)
    inclination_deg: float | None = _off(DesignInput.INCLINATION, 45.0)
    inclination_percent: float | None = _off_percent(DesignInput.INCLINATION)
    restitution: float | None = _off(DesignInput.RESTITUTION, 1.0)
    restitution_percent: float | None = _off_percent(DesignInput.RESTITUTION)
    restitution_bottom: float | None = _off(DesignInput.RESTITUTION_BOTTOM, 1.0)
    restitution_bottom_percent: float | None = _off_percent(DesignInput.RESTITUTION_BOTTOM)
    restitution_top: float | None = _off(DesignInput.RESTITUTION_TOP, 1.0)
    restitution_top_percent: float | None = _off_percent(DesignInput.RESTITUTION_TOP)
    distribution: Distribution = key(
        Distribution.UNIFORM,
        "Distribution of inputs",
        "",
        "How the inputs of the devices that are made lie within their tolerances, for the yield: uniform, or normal "
        "with the tolerance as three standard deviations and nothing beyond.",
        strict=False,
    )
    samples: int = key(
        4096, "Samples", "1", "Random devices from which the yield is estimated; a power of 2.", ge=64, le=2**20
    )

    def off(self, varied: DesignInput) -> tuple[float, float]:
        """The tolerance of an input, in its unit and in per cent; 0 where one is not given."""
        return getattr(self, varied) or 0.0, getattr(self, percent_key(varied)) or 0.0

    def half_width(self, varied: DesignInput, value: float) -> float:
        """The tolerance of an input with this value, in its unit; 0 where it has none."""
        fixed, percent = self.off(varied)
        return max(fixed, value * percent / 100)


def percent_key(varied: DesignInput) -> str:
    """The key of an input's tolerance in per cent: that of the input with another unit."""
    return f"{varied.rpartition('_')[0] if varied.unit else varied}_percent"


MOST_RECORDS = 200

LATEST = 1e9
"""Largest size of a time on a record's clock [s]."""


class Approach(StrEnum):
    """In which direction the swept parameter went from one record to the next."""

    NONE = "none"
    UP = "up"
    DOWN = "down"


class RecordedUnit(StrEnum):
    """The unit of a column of a record; FS is the full scale of a sound card."""

    S, MS, US, NS = "s", "ms", "us", "ns"
    KV, V, MV, UV = "kV", "V", "mV", "uV"
    PA, FS = "Pa", "FS"
    M_S2, MM_S2, G = "m/s2", "mm/s2", "g"
    M, MM, UM = "m", "mm", "um"


class RecordedSign(IntEnum):
    """Whether the sign of a column is kept or turned."""

    KEPT = 1
    TURNED = -1


class DecimalMark(StrEnum):
    """The mark before the decimals of a number."""

    POINT = "."
    COMMA = ","


class Delimiter(StrEnum):
    """The mark between columns of a text."""

    COMMA = ","
    SEMICOLON = ";"
    TAB = "\t"
    BLANKS = " "


def _name_or_number(column: object) -> object:
    number = type(column) is int and column >= 1
    if not number and not (isinstance(column, str) and len(column) <= LONGEST_TEXT and is_printable(column)):
        raise ValueError("neither a name nor a number")
    return column


COLUMN = Annotated[
    TEXT | int,
    PlainValidator(_name_or_number),
    WithJsonSchema({"type": ["string", "integer"], "minLength": 1, "maxLength": LONGEST_TEXT, "minimum": 1}),
]


class ColumnBlock(Block):
    """The column of a file that has a signal, and its unit."""

    column: COLUMN = key(
        REQUIRED, "Column", "", "Name of the column as the file has it, or its number from 1.", example="CH1"
    )
    unit: RecordedUnit | None = key(
        None, "Unit", "", "Unit of its numbers. Left out, it is that which the file states.", strict=False, example="mV"
    )
    sign: RecordedSign = key(
        RecordedSign.KEPT, "Sign", "1", "-1 turns the signal about: a sensor mounted the other way.", strict=False
    )
    scale: float = positive(
        1.0,
        "Scale",
        "1",
        "Value of 1 in the file, in the unit: 10 for a sensor of 100 mV/g whose volts are to be g; full scale of WAV.",
    )


def _column(signal: str) -> Any:
    return key(None, signal, "", f"Column of {signal}.", example={"column": "CH1", "unit": "V"})


class ColumnsBlock(Block):
    """Which column of a file is which signal. What is not named here is not read."""

    time_s: WhenGiven[ColumnBlock] | None = _column("the times")
    bottom_voltage_v: WhenGiven[ColumnBlock] | None = _column("the bottom membrane's voltage")
    top_voltage_v: WhenGiven[ColumnBlock] | None = _column("the top membrane's voltage")
    voltage_v: WhenGiven[ColumnBlock] | None = _column("the voltage of both membranes, first positive at the bottom")
    bottom_sound_pa: WhenGiven[ColumnBlock] | None = _column("the microphone at the bottom membrane")
    top_sound_pa: WhenGiven[ColumnBlock] | None = _column("the microphone at the top membrane")
    sound_pa: WhenGiven[ColumnBlock] | None = _column("one microphone, first positive at the bottom")
    acceleration_m_s2: WhenGiven[ColumnBlock] | None = _column("the capsule's acceleration, positive to the top")
    displacement_m: WhenGiven[ColumnBlock] | None = _column("the capsule's displacement, positive to the top")
    membrane: WhenGiven[ColumnBlock] | None = _column("bottom or top, in a file of impacts")


class LayoutBlock(Block):
    """How to read an instrument's file: what its columns are, and what cannot be found out from the file itself."""

    columns: WhenGiven[ColumnsBlock] | None = key(
        None, "Columns", "", "Which column is which signal. Left out, the columns' names must be those of signals."
    )
    skip_rows: int | None = key(
        None, "Lines to skip", "1", "Lines of a text that are not looked at.", example=12, ge=0, le=1_000_000
    )
    decimal: DecimalMark | None = key(
        None, "Decimal mark", "", "Of the numbers of a text. Left out, it is found out.", strict=False, example=","
    )
    delimiter: Delimiter | None = key(
        None, "Delimiter", "", "Between the columns of a text. Left out, it is found out.", strict=False, example=";"
    )
    sampling_rate_hz: float | None = positive(
        None, "Sampling rate", "Hz", "Where the file has neither times nor a rate.", example=1000.0
    )


class RecordBlock(Block):
    """Impacts of the device that were measured, at one value of the swept parameter or at several in turn."""

    impacts: TEXT = key(
        REQUIRED,
        "Impacts",
        "",
        "CSV file with the columns time_s and membrane (bottom or top), beside the scenario if its path is relative. A "
        "column named as the swept parameter has its value at each impact.",
        example="measured-impacts.csv",
    )
    value: float | None = key(
        None,
        "Value",
        UNIT_OF_SWEPT,
        "Of the swept parameter while they were recorded. Left out, the file has a column of it, or it is that of the "
        "design point.",
        example=0.72,
    )
    direction: Approach = key(
        Approach.NONE,
        "Direction",
        "",
        "In which the swept parameter came to the value, without stopping the device. Of a column it is known.",
        strict=False,
    )
    force_maximum_s: float | None = key(
        None,
        "Force maximum",
        "s",
        "Time of the record at which the force has a maximum. Left out, the phase of the force is fitted.",
        example=0.0,
        ge=-LATEST,
        le=LATEST,
    )
    force_maximum_error_s: float | None = key(
        None, "Its standard error", "s", "Standard error of that time.", example=1e-4, ge=0.0, le=LATEST
    )
    record: WhenGiven[LayoutBlock] | None = key(
        None, "Record", "", "How the file is read, where its columns have other names, units or marks."
    )


class VariedPath(StrEnum):
    """The path of an input in a scenario; `limits` are its smallest and largest value."""

    limits: tuple[float, float]

    def __new__(cls, path: str, limits: tuple[float, float] = (SMALLEST, LARGEST)) -> Self:
        """Make the member whose value is `path`."""
        member = str.__new__(cls, path)
        member._value_, member.limits = path, limits
        return member


_VARIED_INCLINATION = Parameter.INCLINATION.path, Parameter.INCLINATION.limits
_VARIED_RESTITUTION = DesignInput.RESTITUTION.path, DesignInput.RESTITUTION.limits
_VARIED_BOTTOM = DesignInput.RESTITUTION_BOTTOM.path, DesignInput.RESTITUTION_BOTTOM.limits
_VARIED_TOP = DesignInput.RESTITUTION_TOP.path, DesignInput.RESTITUTION_TOP.limits
_BALL_MASS = "device.ball_mass_kg"


class AxisPath(VariedPath):
    """The inputs that a map can vary, by their paths in a scenario."""

    INCLINATION = _VARIED_INCLINATION
    LENGTH = Parameter.LENGTH.path
    AMPLITUDE = Parameter.AMPLITUDE.path
    FREQUENCY = Parameter.FREQUENCY.path
    RESTITUTION = _VARIED_RESTITUTION
    RESTITUTION_BOTTOM = _VARIED_BOTTOM
    RESTITUTION_TOP = _VARIED_TOP
    BALL_MASS = _BALL_MASS


class DesignPath(VariedPath):
    """The inputs that a design can vary, by their paths: those of the device, its membranes and its excitation."""

    INCLINATION = _VARIED_INCLINATION
    LENGTH = Parameter.LENGTH.path
    AMPLITUDE = Parameter.AMPLITUDE.path
    FREQUENCY = Parameter.FREQUENCY.path
    RESTITUTION = _VARIED_RESTITUTION
    RESTITUTION_BOTTOM = _VARIED_BOTTOM
    RESTITUTION_TOP = _VARIED_TOP
    CAPSULE_MASS = DesignInput.CAPSULE_MASS.path
    BALL_MASS = _BALL_MASS
    STIFFNESS = "device.membrane.stiffness"
    EXPONENT = "device.membrane.exponent", (SMALLEST, LARGEST_EXPONENT)
    ACTIVE_RADIUS = "device.membrane.active_radius_m"
    BALL_RADIUS = "device.membrane.ball_radius_m"
    BIAS_VOLTAGE = "device.membrane.bias_voltage_v"
    THICKNESS = "device.membrane.thickness_m"
    PERMITTIVITY = "device.membrane.relative_permittivity"
    BREAKDOWN_FIELD = "device.membrane.breakdown_field_v_m"


class Objective(StrEnum):
    """The quantity that a best design maximises or minimises; the value is its name in results.json's design point.

    Attributes
    ----------
    words, unit : str
        Name and unit for the reader.
    """

    words: str
    unit: str

    def __new__(cls, name: str, words: str = "", unit: str = "") -> Self:
        """Make the member whose value is `name`."""
        member = str.__new__(cls, name)
        member._value_, member.words, member.unit = name, words, unit
        return member

    U_AVE = "u_ave_v", "U_ave", "V"
    VOLTAGE_RATE = "voltage_rate_v_s", "voltage gained per second", "V/s"
    MARGIN = "margin_percent", "smallest margin", "%"
    POWER = "power_mw", "mean electrical power", "mW"
    EFFICIENCY = "efficiency", "efficiency", ""
    U_BOTTOM = "u_bottom_v", "voltage at the bottom", "V"
    U_TOP = "u_top_v", "voltage at the top", "V"
    VELOCITY_BOTTOM = "velocity_bottom", "dimensionless velocity at the bottom", ""
    WALL_GAP = "wall_gap", "dimensionless gap to a membrane", ""
    DEFLECTION = "deflection_m", "deflection of the membranes", "m"
    ACCELERATION = "acceleration_g", "acceleration of the shaker", "g"
    STROKE = "stroke_m", "stroke of the shaker", "m"
    LENGTH = "length_m", "length", "m"
    AMPLITUDE = "amplitude_n", "force amplitude", "N"
    FREQUENCY = "frequency_hz", "frequency", "Hz"
    INCLINATION = "inclination_deg", "inclination", "°"
    CAPSULE_MASS = "capsule_mass_kg", "capsule mass", "kg"
    BALL_MASS = "ball_mass_kg", "ball mass", "kg"
    THICKNESS = "thickness_m", "thickness of the membranes", "m"

    @property
    def path(self) -> DesignPath | None:
        """The input that is the objective; None for a result."""
        return next((path for path in DesignPath if path.rpartition(".")[2] == self.value), None)

    @property
    def needs(self) -> str | None:
        """The path of the key that a scenario must give for the objective; None if it needs none."""
        if self in (Objective.POWER, Objective.EFFICIENCY):
            return "device.membrane.thickness_m"
        of_energy = Objective.U_AVE, Objective.VOLTAGE_RATE, Objective.U_BOTTOM, Objective.U_TOP, Objective.DEFLECTION
        return "device.ball_mass_kg" if self in of_energy else None


class LeftOut(StrEnum):
    """Physical effects that a model may leave out; the value is the name in a scenario and in results.json."""

    RESTITUTION_BOTTOM = "restitution_bottom"
    RESTITUTION_TOP = "restitution_top"
    CAPSULE = "capsule"
    SECOND_HARMONIC = "second_harmonic"
    RESTITUTION_SPEED = "restitution_exponent"
    FRICTION = "friction"
    STIFFNESS = "membrane_stiffness"

    @property
    def varied(self) -> DesignInput | None:
        """The input whose value an effect changes; None where it changes none."""
        return {
            LeftOut.RESTITUTION_BOTTOM: DesignInput.RESTITUTION_BOTTOM,
            LeftOut.RESTITUTION_TOP: DesignInput.RESTITUTION_TOP,
        }.get(self)


SIZED = LeftOut.RESTITUTION_BOTTOM, LeftOut.RESTITUTION_TOP, LeftOut.SECOND_HARMONIC, LeftOut.FRICTION
"""Effects that have a size in per cent."""

EFFECTS = *SIZED, LeftOut.CAPSULE, LeftOut.RESTITUTION_SPEED
"""Effects that a scenario can name; the membranes' own stiffness is always considered where contacts are long."""


class EffectBlock(Block):
    """Something that the model leaves out, of a size."""

    effect: LeftOut = key(
        REQUIRED,
        "Effect",
        "",
        "What is left out: the restitution of one membrane is another, the capsule moves in the other way, the force "
        "has a second harmonic, at its worst phase, the restitution falls with the speed of the impact, or the ball "
        "has friction.",
        example="restitution_bottom",
        strict=False,
    )
    percent: float | None = key(
        None,
        "Per cent",
        "%",
        "By how much the restitution changes, or the harmonic over the force, or the coefficient of friction grows; of "
        "the capsule there is no size.",
        example=-5.0,
        ge=-LARGEST_EFFECT,
        le=LARGEST_EFFECT,
    )
    exponent: float | None = key(
        None,
        "Exponent",
        "1",
        "Of the speed of the impact, with which the restitution falls.",
        example=-0.1,
        ge=STEEPEST_RESTITUTION,
        le=FLATTEST_RESTITUTION,
    )
    speed_m_s: float | None = key(
        None,
        "Speed",
        "m/s",
        "Of the impact at which the restitution is as given, where it falls with speed. Left out, the mean impact "
        "speed of the design's own motion.",
        example=5.0,
        ge=SLOWEST_STATED,
        le=FASTEST_STATED,
    )


class VariedBlock(Block):
    """An input of the design that may vary, and between what."""

    path: DesignPath = key(REQUIRED, "Path", "", "The input.", example="device.length_m", strict=False)
    from_: float = key(REQUIRED, "From", UNIT_OF_VARIED, "One end of its range.", example=0.6, alias="from")
    to: float = key(REQUIRED, "To", UNIT_OF_VARIED, "The other end of its range.", example=0.9)


class DesignBlock(Block):
    """What `vireport optimise` looks for: the best design that meets the requirements; a plain run leaves it alone."""

    vary: tuple[VariedBlock, ...] = key(
        REQUIRED,
        "Vary",
        "",
        "The inputs that may vary.",
        example=[{"path": "device.length_m", "from": 0.6, "to": 0.9}],
        strict=False,
        min_length=1,
        max_length=MOST_VARIED,
    )
    maximise: Objective | None = key(
        None,
        "Maximise",
        "",
        "What shall be as large as possible: an input that varies, or a result, the least of the stable motions. "
        "Either this or minimise.",
        example="u_ave_v",
        strict=False,
    )
    minimise: Objective | None = key(
        None,
        "Minimise",
        "",
        "What shall be as small as possible: an input that varies, or a result, the largest of the stable motions.",
        example="length_m",
        strict=False,
    )
    cells: int = key(
        40_000, "Cells", "1", "Designs of the grid that is searched before the best are refined.", ge=16, le=10_000_000
    )

    @property
    def objective(self) -> Objective:
        """The quantity to maximise or minimise; the rules ensure that exactly one is given."""
        chosen = self.maximise if self.maximise is not None else self.minimise
        assert chosen is not None
        return chosen


@with_added_keys
class Scenario(Block):
    """A vibro-impact energy harvester, its excitation, and what is varied."""

    schema_version: int = key(REQUIRED, "Schema version", "", "Version of this format; 1.", example=1, ge=1, le=1)
    title: TEXT | None = key(
        None, "Title", "", "Free text of one line for the head of the report.", example="Inclined harvester"
    )
    device: DeviceBlock = key(REQUIRED, "Device", "", "The capsule, the ball in it, and the membranes.")
    excitation: ExcitationBlock = key(REQUIRED, "Excitation", "", "The periodic force on the capsule.")
    inclination_deg: float | None = _swept(
        Parameter.INCLINATION, "Inclination", "deg", "Angle beta of the capsule to the horizontal.", 45.0
    )
    gravity_m_s2: float = positive(9.8, "Gravity", "m/s^2", "Gravitational acceleration g.")
    period_ratio: int = key(
        1,
        "Period ratio",
        "1",
        "Forcing periods n that one period of the motion takes, Eq. (3.14).",
        ge=1,
        le=LARGEST_PERIOD_RATIO,
    )
    sweep: SweepBlock | None = key(
        None, "Sweep", "", "The parameter that is varied. Left out, the design point alone is evaluated."
    )
    simulation: WhenGiven[SimulationBlock] | None = key(
        None,
        "Simulation",
        "",
        "The simulation beside the solution. Left out, only the report's own motion is simulated.",
    )
    motions: WhenGiven[MotionsBlock] | None = key(
        None, "Motions", "", "Motions with other sequences of impacts along the sweep. Left out, none is followed."
    )
    tolerances: WhenGiven[TolerancesBlock] | None = key(
        None,
        "Tolerances",
        "",
        "By how much the inputs may be off at the design point. Left out, neither a proof nor a yield is computed.",
        addition="tolerances",
    )
    record: WhenGiven[LayoutBlock] | None = key(
        None,
        "Record",
        "",
        "How the file of `identify --record` or of excitation.record is read. `vireport identify --inspect FILE` "
        "writes it.",
    )
    measured: tuple[WhenGiven[RecordBlock], ...] | None = key(
        None,
        "Measured",
        "",
        "Records of impacts that are shown beside what is computed. Left out, there are none.",
        example=[{"impacts": "measured-impacts.csv"}],
        strict=False,
        min_length=1,
        max_length=MOST_RECORDS,
    )
    requirements: WhenGiven[RequirementsBlock] | None = key(
        None, "Requirements", "", "What the design must meet. Left out, nothing is judged."
    )
    effects: tuple[WhenGiven[EffectBlock], ...] | None = key(
        None,
        "Effects",
        "",
        "What the model leaves out, of which the report says how far it would move the nearest end of stable motion. "
        "Left out, the usual ones: either restitution 5 % less, the other motion of the capsule, a second harmonic of "
        "2 %, a restitution that falls with the speed to the power -0.1, and a coefficient of friction of 0.05.",
        example=[{"effect": "restitution_bottom", "percent": -5.0}],
        strict=False,
        min_length=1,
        max_length=MOST_EFFECTS,
    )
    design: WhenGiven[DesignBlock] | None = key(
        None,
        "Design",
        "",
        "What the best design is looked for in. It makes no difference to a run.",
        addition="optimise",
    )

    @property
    def parameter(self) -> Parameter:
        """The parameter that is swept; the length where none is."""
        return Parameter.LENGTH if self.sweep is None else self.sweep.parameter

    def value_of(self, parameter: Parameter) -> float | None:
        """Value of a parameter at the design point, in its unit; None where it is not given."""
        values = {
            Parameter.LENGTH: self.device.length_m,
            Parameter.AMPLITUDE: self.excitation.amplitude_n,
            Parameter.FREQUENCY: self.excitation.frequency_hz,
            Parameter.INCLINATION: self.inclination_deg,
        }
        if not parameter.bounces:
            return values[parameter]
        # The restitution of one membrane may vary where one number is given for both, and both where each has its own.
        bottom, top = self.device.restitution_bottom, self.device.restitution_top
        if bottom is None or top is None:
            return self.device.restitution
        if parameter is Parameter.RESTITUTION:
            return (bottom + top) / 2
        return bottom if parameter is Parameter.RESTITUTION_BOTTOM else top


@cache
def keys_left_out(model: type[Block]) -> tuple[str, ...]:
    """The paths of a file's keys that belong to additions which are taken out, and so count as unknown."""
    return tuple(path for path, addition in keys_of_additions(model) if addition not in ADDITIONS)


def keys_of_additions(model: type[Block], block: str = "") -> Iterator[tuple[str, str]]:
    """The paths of the keys of a file that belong to additions, each with its addition."""
    for name, field in model.model_fields.items():
        path = f"{block}{field.alias or name}"
        if addition := declared_with(field, "addition"):
            yield path, addition
        if (inner := _block_in(field.annotation)) is not None:
            yield from keys_of_additions(inner, f"{path}.")


def _block_in(annotation: object) -> type[Block] | None:
    """The type of block that a key's value is; None if it is no block, or a list of blocks."""
    if isinstance(annotation, type) and issubclass(annotation, Block):
        return annotation
    parts = () if get_origin(annotation) is tuple else get_args(annotation)
    return next((block for part in parts if (block := _block_in(part)) is not None), None)


class Sampling(StrEnum):
    """How the cells of a map are chosen."""

    GRID = "grid"
    LIST = "list"
    LATIN_HYPERCUBE = "latin_hypercube"
    SOBOL = "sobol"


class Input(NamedTuple):
    """A value of a scenario with its path, title and unit, for the reader.

    Attributes
    ----------
    path : str
        Dotted path of its key.
    title, unit : str
        Title and unit as declared; the unit is `UNIT_OF_SWEPT` for a value of the swept parameter.
    value : object
    """

    path: str
    title: str
    unit: str
    value: object


def key_of(path: str) -> FieldInfo:
    """The declaration of a key, by its path in a scenario."""
    block: Any = Scenario
    *blocks, name = path.split(".")
    for part in blocks:
        kinds = _kinds(block.model_fields[part].annotation)
        block = next(kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Block))
    key: FieldInfo = block.model_fields[name]
    return key


def _kinds(annotation: object) -> Iterator[object]:
    """The types that an annotation allows."""
    yield annotation
    for kind in get_args(annotation):
        yield from _kinds(kind)


def set_in_type(unit: str) -> str:
    """The unit of a key as pages print it."""
    return UNITS.get(unit, unit)


def unit_of(key: FieldInfo) -> str:
    """The unit that a key is declared with, "" where it has none."""
    return declared_with(key, "unit")


def inputs(block: Block, path: str = "") -> Iterator[Input]:
    """Every value of a block and of the blocks within it, in the order of the format; absent ones are left out.

    Lists of blocks other than harmonics are left out too, as they do not describe the device.
    """
    for name, field in type(block).model_fields.items():
        value, path_of_key = getattr(block, name), f"{path}{field.alias or name}"
        if isinstance(value, Block):
            yield from inputs(value, f"{path_of_key}.")
        elif isinstance(value, tuple) and any(isinstance(row, HarmonicBlock) for row in value):
            yield Input(path_of_key, field.title or "", unit_of(field), tuple(map(str, value)))
        elif value is not None and not (isinstance(value, tuple) and any(isinstance(row, Block) for row in value)):
            yield Input(path_of_key, field.title or "", unit_of(field), value)


def to_dict(block: Block) -> dict[str, Any]:
    """Return a block as plain data, defaults filled in, by the names and in the order of the file.

    Optional keys that are absent are None; keys of additions that are taken out are left out. Loading the result gives
    an equal block.
    """
    data = block.model_dump(mode="json", by_alias=True)
    for path in keys_left_out(type(block)):
        *parents, key = path.split(".")
        within: Any = data
        for parent in parents:
            within = (within or {}).get(parent)
        if within is not None:
            within.pop(key, None)
    return data
