"""Records of results.json: what is written and what is read, with the names that scripts rely on.

A key without a default has been written by every version. One with a default may be missing: earlier versions, or a
run that had no use for it, do not write it. Keys that are not declared are passed over where a file is read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from msgspec import UNSET, UnsetType, field

from vireport.base.records import ResultsBlock, keyed
from vireport.motions.events import Event
from vireport.motions.stability import Stability
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter

SCHEMA_VERSION = 1

ADDED = "*"
"""Stands for the keys of additions to a study among those of a file of results."""

Numbers = list[float]
SomeNumbers = list[float | None]
"""Null where a number does not exist or is beyond the range of doubles."""

MotionRow = dict[str, float | str | None]
"""A row of a table of motions, by the names of its columns."""

AddedBlocks = Mapping[str, ResultsBlock | Sequence[ResultsBlock] | None]
"""Blocks of additions by their keys, null where nothing was found."""

Bounds = dict[str, list[float | None] | str]
"""Error bounds by the names of columns, and under ``null_means`` why some are null."""


class Range(ResultsBlock, frozen=True, kw_only=True):
    """A range of an input, from one value to the other.

    Attributes
    ----------
    from_, to
        ends of the range
    """

    from_: float
    to: float


MOTION_COLUMNS = (
    *("sweep_value", "d", "gbar", "q", "phi_bottom_rad", "phi_top_rad", "velocity_bottom", "velocity_top"),
    *("trace", "determinant", "discriminant", "stability", "admissible", "wall_gap", "admissible_undecided"),
    *("u_bottom_v", "u_top_v", "u_ave_v", "deflection_m"),
)
"""Keys of a branch, and of a design point, that have a value for each motion."""


class BranchData(ResultsBlock, frozen=True, kw_only=True):
    """A branch of 1:1 motions: all but the first four and the bounds are arrays of equal length, along the curve.

    Attributes
    ----------
    number
        its number
    family
        `symmetric` or `asymmetric`
    mirror_of
        number of the branch whose mirror image it is; null where there is none
    ends
        why it ends on either side
    sweep_value : as in the scenario
        the swept parameter
    d, gbar : 1
        dimensionless length and gravity
    q : 1
        share of the period that the flight from bottom to top takes
    phi_bottom_rad, phi_top_rad : rad
        phase of the force at the impacts
    velocity_bottom, velocity_top : F π/(M ω)
        relative velocity before the impacts
    trace, determinant, discriminant : 1
        of the linearised return map; the trace diverges where an impact loses its velocity, and is given just before
        that end
    stability
        `stable node`, `stable focus`, `unstable node` or `unstable focus`; at a critical point that of the less
        stable side
    admissible
        whether the ball stays between the membranes; rows that are not solve the equations but are no motions
    wall_gap : F π²/(M ω²)
        least distance between ball and membrane at the turning points of the flights, negative where the ball would
        pass through; d if it does not turn. [With friction](model.md#friction), the negative velocity of a ball that
        would turn back
    u_bottom_v, u_top_v, u_ave_v : V
        voltage above the bias at either impact, and their mean, (5.1); absent without `ball_mass_kg`
    deflection_m : m
        larger deflection of the two impacts, (5.5); absent without `ball_mass_kg`
    critical_point
        label of the critical point, if the row is one; else null
    admissible_undecided
        whether `wall_gap` is within its error bound of zero, so that rounding decides `admissible`, as at a grazing
        point itself
    error_bounds
        [bounds](#error-bounds) of these columns
    """

    columns: ClassVar[tuple[str, ...]] = (*MOTION_COLUMNS, "critical_point")

    number: int = 0
    family: str = ""
    mirror_of: int | None = None
    ends: list[str] = []
    sweep_value: SomeNumbers = []
    d: SomeNumbers = []
    gbar: SomeNumbers = []
    q: SomeNumbers = []
    phi_bottom_rad: SomeNumbers = []
    phi_top_rad: SomeNumbers = []
    velocity_bottom: SomeNumbers = []
    velocity_top: SomeNumbers = []
    trace: SomeNumbers = []
    determinant: SomeNumbers = []
    discriminant: SomeNumbers = []
    stability: list[Stability]
    admissible: list[bool]
    wall_gap: SomeNumbers = []
    u_bottom_v: SomeNumbers | UnsetType = UNSET
    u_top_v: SomeNumbers | UnsetType = UNSET
    u_ave_v: SomeNumbers | UnsetType = UNSET
    deflection_m: SomeNumbers | UnsetType = UNSET
    critical_point: list[str | None] = []
    admissible_undecided: list[bool] = []
    error_bounds: Bounds = {}


class OneToOneData(ResultsBlock, frozen=True, kw_only=True):
    """A 1:1 motion at a critical point.

    Attributes
    ----------
    q, phi_bottom_rad, velocity_bottom, velocity_top, error_bounds
        as of the point
    """

    q: float
    phi_bottom_rad: float
    velocity_bottom: float
    velocity_top: float
    error_bounds: dict[str, float | None] = {}


class CriticalPointData(ResultsBlock, frozen=True, kw_only=True):
    """A critical point, its 1:1 motion, and the mirror image of that where there is one.

    Attributes
    ----------
    label
        its letter and number
    kind
        `period_doubling`, `fold`, `pitchfork`, `node_focus`, `grazing` or, [with friction](model.md#friction),
        `stop_in_flight`
    family
        `symmetric` or `asymmetric`
    sweep_value, error_bound : as in the scenario
        the swept parameter there, and the bound of its error
    d, gbar, q, phi_bottom_rad, phi_top_rad, velocity_bottom, velocity_top
        as of a [branch](#branches)
    error_bounds
        [bounds](#error-bounds) of these
    mirror
        `q`, phase, velocities and `error_bounds` of the mirror image; null where there is none
    branch
        number of its branch
    detail
        what happens there, in words
    """

    label: str
    kind: Event
    family: str
    sweep_value: float
    error_bound: float
    d: float
    gbar: float | None = None
    q: float | None = None
    phi_bottom_rad: float | None = None
    velocity_bottom: float | None = None
    velocity_top: float | None = None
    error_bounds: dict[str, float | None] = {}
    phi_top_rad: float | None = None
    mirror: OneToOneData | None = None
    branch: int | None = None
    detail: str = ""


class HarmonicSlopes(ResultsBlock, frozen=True, kw_only=True):
    """Derivatives by the cosine and the sine of a harmonic of the force, for one per cent of it.

    Attributes
    ----------
    cosine, sine : per %
        derivatives with respect to A and B in F[cos x + (A cos kx + B sin kx)/100]
    """

    cosine: float
    sine: float


class MarginData(ResultsBlock, frozen=True, kw_only=True):
    """A margin of the design point: the distance to a critical point when one input varies.

    Attributes
    ----------
    parameter, unit
        the input that varies, and its unit
    label, kind, family
        of the critical point; the label is that of the sweep's critical point, and empty for an end that is not one
        of these
    sweep_value, error_bound : `unit`
        the input at the critical point, and the bound of its error
    distance : `unit`
        signed distance from the design point
    relative, percent : 1, %
        distance over the input's value; null where that is zero
    ends_stability
        whether stable motion ends there
    taken_over
        whether the motion ends there and another stable one takes over
    derivatives
        of `sweep_value` with respect to the other inputs; null where there is none
    derivatives_by_harmonic
        by the order of a harmonic of the force, those with respect to its `cosine` and `sine`
    """

    parameter: DesignInput
    label: str
    kind: Event
    family: str
    sweep_value: float
    distance: float
    relative: float | None
    unit: str = ""
    percent: float | None = None
    ends_stability: bool
    taken_over: bool = False
    error_bound: float
    derivatives: dict[str, float | None] = {}
    derivatives_by_harmonic: dict[str, HarmonicSlopes | None] = {}


class EndBeyondSweep(ResultsBlock, frozen=True, kw_only=True):
    """Where a stable range would end if the sweep went on.

    Attributes
    ----------
    sweep_value, error_bound : as in the scenario
        where stable motion would end, and the bound of its error
    kind, d, gbar
        of the critical point there
    """

    sweep_value: float
    kind: Event
    d: float
    gbar: float
    error_bound: float


class StableRangeData(ResultsBlock, frozen=True, kw_only=True):
    """A range of an input with stable admissible motion, and what ends it on either side.

    Attributes
    ----------
    parameter
        the input
    from_, to : as in the scenario
        ends of the range
    from_reason, to_reason
        label of the critical point there, in words what it is if it has none, or `end of the sweep`; at the design
        point `limit of the input`
    from_error_bound, to_error_bound : as in the scenario
        bounds of the errors of both ends
    settable
        false if the range is narrower than a tenth of the input's tolerance or, without one, than 1e-6 of its value;
        the first page leaves out such ranges
    from_beyond_sweep, to_beyond_sweep
        where only the sweep ends, the point at which stable motion would end; null where it ends within the sweep, or
        nowhere; absent at the design point
    """

    parameter: str = ""
    from_: float
    to: float
    from_reason: str
    to_reason: str
    from_error_bound: float | None = None
    to_error_bound: float | None = None
    settable: bool = True
    from_beyond_sweep: EndBeyondSweep | UnsetType | None = UNSET
    to_beyond_sweep: EndBeyondSweep | UnsetType | None = UNSET


class DistortionData(ResultsBlock, frozen=True, kw_only=True):
    """The least harmonic of an order that ends a stable motion of the design point.

    Attributes
    ----------
    order
        of the harmonic, 2 or 3
    percent : %
        least amplitude that was found to end a stable motion of the design point, F[cos x + percent/100 cos(order x +
        phase)]; null where there is none up to `searched_to_percent`
    phase_deg : degrees
        its most critical phase; null without one
    kind
        what ends the motion; null without one
    error_bound_percent : %
        bound of the error of `percent`; null where the end was located in double precision only
    searched_to_percent : %
        up to which amplitude it was looked for
    """

    order: int
    percent: float | None
    phase_deg: float | None
    kind: Event | None
    error_bound_percent: float | None
    searched_to_percent: float


class DesignData(ResultsBlock, frozen=True, kw_only=True):
    """The motions at the design point, as arrays of equal length, with margins and stable ranges.

    Attributes
    ----------
    parameter, value
        the swept parameter, or the length, and its value
    family
        `symmetric` or `asymmetric`
    sweep_value, d, gbar, q, phi_bottom_rad, phi_top_rad, velocity_bottom, velocity_top
        as of a [branch](#branches)
    trace, determinant, discriminant, stability, admissible, wall_gap, admissible_undecided, error_bounds
        as of a [branch](#branches)
    u_bottom_v, u_top_v, u_ave_v, deflection_m
        as of a [branch](#branches)
    energy_bottom_j, energy_top_j : J
        electrical energy gained at either impact, C0 U_imp (U_imp − Uin)/2
    power_mw : mW
        mean power, both energies over the period of the motion
    efficiency : 1
        energy gained over energy lost at the impacts, both energies over the sum of m V² (1 − r²)/2
    field_v_m : V/m
        highest field in either membrane, U_imp/κ
    margins
        distances to critical points
    margins_unresolved
        inputs along which rounding does not resolve where stable motion ends
    stable_range
        for each input the range around the design point, up to the first end of a stable motion on either side
    distortion
        the least harmonics that end stable motion; null without a `disturbances:` block and the requirement
        `withstands_distortion_percent`
    distortion_reason
        why `distortion` is null; else null
    restitution_bottom, restitution_top : 1
        those of each motion's impacts, for a [restitution that falls with
        speed](model.md#a-restitution-that-falls-with-speed); else absent
    claim, not_followed
        `followed`, and the number of motions that are lost on the way from a constant restitution; absent for a
        constant one
    """

    columns: ClassVar[tuple[str, ...]] = (
        *("family", *MOTION_COLUMNS, "energy_bottom_j", "energy_top_j", "power_mw", "efficiency", "field_v_m"),
        *("restitution_bottom", "restitution_top"),
    )

    parameter: Parameter
    value: float
    family: list[str]
    sweep_value: SomeNumbers = []
    d: SomeNumbers = []
    gbar: SomeNumbers = []
    q: Numbers
    phi_bottom_rad: Numbers
    phi_top_rad: Numbers
    velocity_bottom: Numbers
    velocity_top: Numbers
    trace: SomeNumbers = []
    determinant: SomeNumbers = []
    discriminant: SomeNumbers = []
    stability: list[Stability]
    admissible: list[bool]
    wall_gap: SomeNumbers = []
    u_bottom_v: SomeNumbers | UnsetType = UNSET
    u_top_v: SomeNumbers | UnsetType = UNSET
    u_ave_v: SomeNumbers | UnsetType = UNSET
    deflection_m: SomeNumbers | UnsetType = UNSET
    energy_bottom_j: SomeNumbers | UnsetType = UNSET
    energy_top_j: SomeNumbers | UnsetType = UNSET
    power_mw: SomeNumbers | UnsetType = UNSET
    efficiency: SomeNumbers | UnsetType = UNSET
    field_v_m: SomeNumbers | UnsetType = UNSET
    admissible_undecided: list[bool] = []
    error_bounds: Bounds = {}
    margins: list[MarginData]
    margins_unresolved: list[str] = []
    stable_range: list[StableRangeData] = []
    distortion: list[DistortionData] | None = None
    distortion_reason: str | None = None
    restitution_bottom: SomeNumbers | UnsetType = UNSET
    restitution_top: SomeNumbers | UnsetType = UNSET
    claim: str | UnsetType = UNSET
    not_followed: int | UnsetType = UNSET


class ShakerData(ResultsBlock, frozen=True, kw_only=True):
    """Demands on the shaker; null beyond the range of doubles.

    Attributes
    ----------
    acceleration_amplitude_g, acceleration_amplitude_m_s2 : g, m/s²
        acceleration; of a free capsule the largest between impacts, (F + m g sin β)/M
    velocity_amplitude_m_s : m/s
        velocity; of a free capsule that without recoil
    stroke_m : m
        from end to end; of a free capsule a bound, (2 F/ω² + m s)/(M + m)
    force_amplitude_n : N
        force
    """

    acceleration_amplitude_g: float | None
    acceleration_amplitude_m_s2: float | None
    velocity_amplitude_m_s: float | None
    stroke_m: float | None
    force_amplitude_n: float | None = None


class FittingData(ResultsBlock, frozen=True, kw_only=True):
    """Changes that would each keep the deepest deflection within the active radius; null beyond the range of doubles.

    Attributes
    ----------
    ball_mass_at_most_kg : kg
        mass of the ball
    stiffness_at_least : as in the scenario
        K
    active_radius_at_least_m : m
        active radius
    """

    ball_mass_at_most_kg: float | None
    stiffness_at_least: float | None
    active_radius_at_least_m: float | None


class StretchData(ResultsBlock, frozen=True, kw_only=True):
    """How far the deepest impact of the stable motions stretches a membrane; null beyond the range of doubles.

    Attributes
    ----------
    deflection_m, deflection_over_radius : m, 1
        deflection, and its share of the active radius
    area_ratio : 1
        area of the membrane to that when it is flat
    u_imp_v : V
        voltage
    thickness_needed_m : m
        thickness that this voltage needs at the breakdown field
    at_field_v_m : V/m
        breakdown field, that of the scenario or else 100 MV/m
    """

    deflection_m: float | None
    deflection_over_radius: float | None
    area_ratio: float | None
    u_imp_v: float | None
    thickness_needed_m: float | None
    at_field_v_m: float | None


class TableRowData(ResultsBlock, frozen=True, kw_only=True):
    """A row of the paper's Table 1.

    Attributes
    ----------
    family, branch
        `symmetric` or `asymmetric`, and the number of the branch
    start_label, end_label
        labels of the critical points at its ends; empty where there is none
    criteria, stability
        what trace, determinant and discriminant satisfy, and the stability
    d_start, d_end, sweep_start, sweep_end
        d and the swept parameter at its ends
    error_bounds
        bounds of these four
    """

    family: str
    branch: int
    start_label: str
    end_label: str
    criteria: str
    stability: str
    d_start: float
    d_end: float
    sweep_start: float
    sweep_end: float
    error_bounds: dict[str, float | None] = {}


class KindOfMotion(ResultsBlock, frozen=True, kw_only=True):
    """What kind of motion it is; a word and a period are of periodic ones.

    Attributes
    ----------
    outcome
        `periodic`, `sticking` (periodic, with rests on a membrane), `aperiodic`, `rest`, `held` (by friction),
        `creeping`, `free` (it reaches no membrane) or `unresolved`
    word, period
        impacts of a period, and its forcing periods; null where it does not repeat
    """

    outcome: str
    word: str | None
    period: int | None


class CountedMotion(KindOfMotion, frozen=True, kw_only=True):
    """A kind of motion that starts end in, how many do, and between which values of the parameter.

    Attributes
    ----------
    count
        starts that end in it
    from_, to : as in the scenario
        least and largest value of the swept parameter at which it was seen
    """

    count: int
    from_: float
    to: float


class MissData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion on which the simulation did not end.

    Attributes
    ----------
    sweep_value, outcome
        value of the swept parameter, and the motion on which the simulation ended instead
    """

    sweep_value: float
    outcome: str


class BasinShares(ResultsBlock, frozen=True, kw_only=True):
    """The share of the starts that lead to a 1:1 motion, with its interval of 95 %.

    Attributes
    ----------
    trials, reached
        starts, and how many reach a 1:1 motion
    share, low_95, high_95 : 1
        their share and its 95 % interval
    elsewhere
        motions that the others reach
    """

    trials: int
    reached: int
    share: float
    low_95: float
    high_95: float
    elsewhere: list[CountedMotion]


class StartEnd(KindOfMotion, frozen=True, kw_only=True):
    """What a start leads to.

    Attributes
    ----------
    residual : 1
        largest difference of phase and velocity after a period; null where it does not repeat
    multiplier : 1
        modulus of its larger multiplier; null where it does not repeat
    lyapunov : 1/forcing period
        largest Lyapunov exponent, an estimate where the motion does not repeat; null where the ball comes to rest
    error_bounds
        bounds of `multiplier` and `lyapunov`; null where there are none
    """

    residual: float | None
    multiplier: float | None
    lyapunov: float | None
    error_bounds: dict[str, float | None]


class SampleData(ResultsBlock, frozen=True, kw_only=True):
    """What the starts at one value of the parameter lead to.

    Attributes
    ----------
    sweep_value, d
        value of the swept parameter, and d
    start_velocity_at_most : F π/(M ω)
        largest velocity of the starts
    ends
        what each start leads to
    """

    sweep_value: float
    d: float
    start_velocity_at_most: float
    ends: list[StartEnd]


class StageData(ResultsBlock, frozen=True, kw_only=True):
    """The motion at a value of a sweep that is gone through slowly, with its impacts.

    Attributes
    ----------
    sweep_value
        value of the swept parameter
    outcome, word, period
        the motion, as of `simulation.motions`
    wall, phase_rad, velocity
        impacts of one period, or the last 256 of a motion that is not periodic: 1 on the bottom and −1 on the top,
        phase [rad], velocity [F π/(M ω)]
    """

    sweep_value: float
    outcome: str
    word: str | None
    period: int | None
    wall: list[int]
    phase_rad: SomeNumbers
    velocity: SomeNumbers


class VertexData(ResultsBlock, frozen=True, kw_only=True):
    """The critical point at which a motion ends before a jump.

    Attributes
    ----------
    label, kind, sweep_value
        of that end
    """

    label: str
    kind: Event
    sweep_value: float


class JumpData(ResultsBlock, frozen=True, kw_only=True):
    """A jump from one motion to another.

    Attributes
    ----------
    from_, to : as in the scenario
        ends of the interval that contains the jump
    before, after
        the motions (`outcome`, `word`, `period`)
    vertex
        nearest end of the family before; null if none is known within the distance of two values
    """

    from_: float
    to: float
    before: KindOfMotion
    after: KindOfMotion
    vertex: VertexData | None


class CourseData(ResultsBlock, frozen=True, kw_only=True):
    """The motions at the values in their order, and the jumps between them.

    Attributes
    ----------
    samples
        the motion at each value, in the order of the sweep
    jumps
        from one motion to another
    """

    samples: list[StageData]
    jumps: list[JumpData]


class LoopData(ResultsBlock, frozen=True, kw_only=True):
    """A range in which the motion depends on the direction of the sweep.

    Attributes
    ----------
    from_, to, width : as in the scenario
        a range in which the motion depends on the direction
    up, down
        the motions in between (`outcome`, `word`, `period`)
    """

    from_: float
    to: float
    width: float
    up: KindOfMotion
    down: KindOfMotion


class CoexistingData(KindOfMotion, frozen=True, kw_only=True):
    """A kind of motion, and the ranges in which it was found, by what found it.

    Attributes
    ----------
    up, down, starts, families
        ranges in which it was seen: in either direction, from random starts, and stable as a family
    """

    up: list[list[float]] = []
    down: list[list[float]] = []
    starts: list[list[float]] = []
    families: list[list[float]] = []


class FollowData(ResultsBlock, frozen=True, kw_only=True):
    """What a sweep that is gone through slowly meets, upwards and downwards.

    Attributes
    ----------
    up, down
        what is met in this direction; null where it was not swept
    loops
        hysteresis between both
    coexisting
        each motion with its ranges
    """

    up: CourseData | None
    down: CourseData | None
    loops: list[LoopData]
    coexisting: list[CoexistingData]


class SimulationData(ResultsBlock, frozen=True, kw_only=True):
    """The cross-check by simulation.

    Attributes
    ----------
    passed, orbits_checked
        whether simulation and solution agree, and how many stable motions were simulated
    velocity_difference, phase_difference_rad : F π/(M ω), rad
        largest differences; null where no motion was simulated
    error_bounds
        bounds of both, of their rounding errors
    tolerance
        up to which they agree
    misses
        stable motions on which the simulation did not end
    basin
        share of random starts that reach a 1:1 motion; null where none was tried
    motions
        motions that starts reach
    samples
        where the starts at each value end
    follow
        [the slow sweep](#slow-sweep); null where it is not asked for
    """

    passed: bool
    orbits_checked: int
    velocity_difference: float | None
    phase_difference_rad: float | None
    error_bounds: dict[str, float | None] = {}
    tolerance: float | None = None
    misses: list[MissData] = []
    basin: BasinShares | None = None
    motions: list[CountedMotion] = []
    samples: list[SampleData] = []
    follow: FollowData | None = None


class CompletenessData(ResultsBlock, frozen=True, kw_only=True):
    """How completely the families of a word are found; a word of null is of all words that are not listed.

    Attributes
    ----------
    word
        the impacts; null for all words that are not listed
    claim
        `complete` (all families), `searched` (families smaller than the resolution can be missed) or `followed`
        (those that join others)
    resolution : forcing period
        in flight times; null where families are in closed form
    undecided : 1
        undecided share of the flight times; null where nothing is searched
    """

    word: str | None
    claim: str
    resolution: float | None
    undecided: float | None


class MotionsData(ResultsBlock, frozen=True, kw_only=True):
    """The limits of the motions that are looked for, and how completely they are found.

    Attributes
    ----------
    impacts, periods
        limits of the motions that are looked for
    followed_impacts
        number of impacts up to which every family that joins another is followed (less than `impacts` where longer
        words join in more than 1000 ways)
    families_found
        number of families. The results in a page contain [at most 150](model.md#motions-of-other-impact-sequences) of
        them
    completeness
        how completely the families of each word are found
    """

    impacts: int
    periods: int
    followed_impacts: int | None = None
    families_found: int | None = None
    completeness: list[CompletenessData] = []


class FamilyEnd(ResultsBlock, frozen=True, kw_only=True):
    """What a family begins or ends with.

    Attributes
    ----------
    kind
        that of a critical point, or `zero_velocity` (an impact loses its velocity), `sweep_end`, `closed_curve`,
        `not_followed`
    label, families, sweep_value
        label of the point or null, the families that meet there, and the swept parameter
    """

    kind: Event
    label: str | None
    families: list[int]
    sweep_value: float


class FamilyPoint(ResultsBlock, frozen=True, kw_only=True):
    """What happens to a motion of a family.

    Attributes
    ----------
    label, kind
        label of the 1:1 critical point if it is one, else a further number, null between node and focus; its kind
    sweep_value, error_bound : as in the scenario
        the swept parameter there, and the bound of its error, null where several events coincide
    d, gbar
        as of a [branch](#branches)
    word, velocity, phase_rad
        impacts of the motion; at grazing, the touch is an impact of velocity zero
    families
        those that meet there
    """

    label: str | None
    kind: Event
    sweep_value: float
    error_bound: float | None
    d: float
    gbar: float | None = None
    word: str | None = None
    velocity: Numbers
    phase_rad: Numbers
    families: list[int]


class GenerationData(ResultsBlock, frozen=True, kw_only=True):
    """Voltages and impacts of a motion of a family.

    Attributes
    ----------
    sweep_value
        value of the swept parameter
    u_impacts_v, u_ave_v, u_per_second_v : V, V, V/s
        voltages of the impacts, their mean, and their sum over a second; null beyond the range of doubles
    impacts_per_s : 1/s
        impacts per second; null beyond the range of doubles
    """

    sweep_value: float
    u_impacts_v: SomeNumbers
    u_ave_v: float | None
    impacts_per_s: float | None
    u_per_second_v: float | None


class MultipliersData(ResultsBlock, frozen=True, kw_only=True):
    """Multipliers of a motion, by their parts.

    Attributes
    ----------
    real, imaginary
        parts of the eigenvalues of the linearised return map
    """

    real: SomeNumbers
    imaginary: SomeNumbers


class MultipliersOfFamily(ResultsBlock, frozen=True, kw_only=True):
    """Multipliers of every motion of a family, by their parts.

    Attributes
    ----------
    real, imaginary
        parts of the eigenvalues of the linearised return map, a list for each motion
    """

    real: list[SomeNumbers]
    imaginary: list[SomeNumbers]


class FamilyBounds(ResultsBlock, frozen=True, kw_only=True):
    """Error bounds of the motions of a family.

    Attributes
    ----------
    sweep_value, velocity, phase_rad
        bounds of the columns of these names
    null_means
        why some are null
    """

    sweep_value: SomeNumbers
    velocity: list[SomeNumbers]
    phase_rad: list[SomeNumbers]
    null_means: str = ""


class FamilyData(ResultsBlock, frozen=True, kw_only=True):
    """A family of motions of other impact sequences: from `sweep_value` on, arrays along the family.

    Attributes
    ----------
    number
        its number, to which the `families` of a point refer
    word, ratio, periods
        impacts of one period, B bottom and T top; 2:1 for two on the bottom and one on the top; number of forcing
        periods
    from_, to : as in the scenario
        its range of the swept parameter
    begins_with, ends_with
        what happens at its ends
    stable_range
        parts of the range in which the motions are stable, `from` and `to`
    critical_points
        what happens to its motions
    generation
        voltages at both ends and in the middle; empty without `ball_mass_kg`
    sweep_value, d
        arrays along the family, as of a [branch](#branches)
    velocity, phase_rad, time, u_impacts_v : F π/(M ω), rad, half a forcing period, V
        a list of N impacts for each motion; voltages are absent without `ball_mass_kg`
    trace, multipliers
        of the linearised return map, arrays along the family; null where a velocity is zero
    determinant
        of the linearised return map, r<sup>2N</sup>
    stable
        whether each motion is stable
    impacts_per_s : 1/s
        impacts per second
    u_ave_v, u_per_second_v : V, V/s
        mean voltage of the impacts, and their sum over a second; absent without `ball_mass_kg`
    error_bounds
        [bounds](#error-bounds) of `sweep_value`, `velocity` and `phase_rad`
    """

    number: int
    word: str
    ratio: str
    periods: int
    from_: float
    to: float
    begins_with: FamilyEnd
    ends_with: FamilyEnd
    stable_range: list[Range] = []
    critical_points: list[FamilyPoint] = []
    generation: list[GenerationData] = []
    determinant: float | None = None
    stable: list[bool] = []
    multipliers: MultipliersOfFamily | None = None
    sweep_value: Numbers
    d: Numbers
    velocity: list[Numbers]
    phase_rad: list[Numbers]
    time: list[Numbers]
    trace: SomeNumbers = []
    impacts_per_s: SomeNumbers = []
    u_impacts_v: list[SomeNumbers] | UnsetType = UNSET
    u_ave_v: SomeNumbers | UnsetType = UNSET
    u_per_second_v: SomeNumbers | UnsetType = UNSET
    error_bounds: FamilyBounds | None = None


class CompliantMotionData(ResultsBlock, frozen=True, kw_only=True):
    """The motion with the membranes' stiffness.

    Attributes
    ----------
    velocity_bottom, velocity_top, phi_bottom_rad, phi_top_rad, trace, determinant
        as of a [branch](#branches)
    contact_share : 1
        share of the period in which the ball touches a membrane
    stable
        whether it is stable
    error_estimate : 1
        estimate of the error; null where there is none
    """

    velocity_bottom: float
    velocity_top: float
    phi_bottom_rad: float
    phi_top_rad: float
    contact_share: float
    trace: float
    determinant: float
    stable: bool
    error_estimate: float | None


class CompliantEndData(ResultsBlock, frozen=True, kw_only=True):
    """An end of stable motion, with rigid impacts and with the membranes' stiffness.

    Attributes
    ----------
    parameter, label, kind
        the input that varies, the label of the rigid critical point or null, and its kind
    of_sweep
        whether it is an end of the stable ranges of the sweep
    design_value : as in the scenario
        value at the design point; null without a stable motion there
    rigid, compliant, error_estimate : as in the scenario
        where stable motion ends with rigid impacts and with the membranes' stiffness, and the error of the latter;
        null where it is missing
    missing, reason
        `lost`, `not found` or `not followed`, and why, in words; else null
    rigid_margin, compliant_margin : 1
        margins over the design value, negative if the end is on the other side; null without a stable motion at the
        design point, or an end
    """

    parameter: str
    label: str | None
    kind: Event
    of_sweep: bool
    design_value: float | None
    rigid: float
    compliant: float | None
    error_estimate: float | None
    missing: str | None
    reason: str | None
    rigid_margin: float | None
    compliant_margin: float | None


class OwnStiffnessData(ResultsBlock, frozen=True, kw_only=True):
    """The motion and its ends with the membranes' stiffness, where contacts are long.

    Attributes
    ----------
    parameter, value, at_design_point
        where the motion is: swept parameter, or length, and its value, and whether that is the design point
    margin_gone
        whether no compliant margin is left
    motion
        with the membranes' stiffness; null where it is missing
    missing, reason
        as of an end
    ends
        of stable motion
    """

    parameter: str
    value: float
    at_design_point: bool
    margin_gone: bool
    motion: CompliantMotionData | None
    missing: str | None
    reason: str | None
    ends: list[CompliantEndData]


class EffectRow(ResultsBlock, frozen=True, kw_only=True):
    """Where the nearest end of stable motion is with an effect that the model leaves out.

    Attributes
    ----------
    effect, change
        the effect and its size; null where it has none
    speed_m_s : m/s
        v₀ of `restitution_exponent`; else null
    sweep_value, kind
        the end with it; null where there is none, or none is known, as `reason` says
    moved, moved_relative : as in the scenario, 1
        distance by which the end has moved, also over its value; null as the end
    margin_left : 1
        remaining margin over the value of the design point, negative where the end has passed it; null as the end
    least_margin : 1
        the least in any input, if `requirements.margin_with_effects_percent` asks for it: 0 where no motion is
        stable, null where it is not asked for or no motion ends
    stable
        whether the design point still is; null where that is not known
    reason
        why they are null: there is no end, or none is known
    """

    effect: str
    change: float | None
    speed_m_s: float | None = None
    sweep_value: float | None
    kind: Event | None
    moved: float | None
    moved_relative: float | None
    margin_left: float | None
    least_margin: float | None = None
    stable: bool | None
    reason: str | None


class EffectsData(ResultsBlock, frozen=True, kw_only=True):
    """The nearest end of stable motion, and where it is with each effect that the model leaves out.

    Attributes
    ----------
    parameter, label, kind, sweep_value, relative
        as of a [margin](#design-point-and-stable-ranges)
    reason
        why there is no such end; else null
    rows
        where that end is with each effect
    """

    parameter: str | None
    label: str | None
    kind: Event | None
    sweep_value: float | None
    relative: float | None
    reason: str | None
    rows: list[EffectRow]


class MarginToUseData(ResultsBlock, frozen=True, kw_only=True):
    """The least margin that rigid impacts, soft membranes and neglected effects leave.

    Attributes
    ----------
    parameter, relative
        the input, and the margin over its value, null where stable motion is lost, or the value is zero
    limited_by
        `rigid`, `compliant` or `effect`
    effect, change
        the effect and its relative size; null where it is none
    gone
        whether no margin is left
    """

    parameter: str
    relative: float | None
    limited_by: str
    effect: str | None
    change: float | None
    gone: bool


class CriterionData(ResultsBlock, frozen=True, kw_only=True):
    """A line of the acceptance table.

    Attributes
    ----------
    key, title, line
        the requirement, in words, and its line in the scenario, null where it is not from there
    limit, limit_value, unit
        what is required, as text and as a number, null where it is none
    by_default
        whether it is required without being asked for
    value, value_text, error_bound
        what was computed, as text too, and the bound of its error; null where there is none
    margin
        how far the value is within the limit, in the same unit, negative beyond it; null where there is none
    passed, why
        whether it is met, and why, where that needs words
    """

    key: str
    title: str = ""
    limit: str = ""
    limit_value: float | None = None
    unit: str = ""
    by_default: bool = False
    value: float | None = None
    value_text: str = ""
    margin: float | None = None
    passed: bool
    why: str = ""
    error_bound: float | None = None
    line: int | None = None


class RequirementsData(ResultsBlock, frozen=True, kw_only=True):
    """The acceptance table, and whether all that is required is met.

    Attributes
    ----------
    passed
        whether all are met
    criteria
        a line for each
    """

    passed: bool
    criteria: list[CriterionData]


class FollowedRange(ResultsBlock, frozen=True, kw_only=True):
    """The range of an input over which a motion exists and is stable, and what ends it.

    Attributes
    ----------
    parameter, from_, to
        the swept input, or else the length, on a table the force; and the range in which the motion is stable
    from_reason, to_reason
        what ends it, such as `sweep_end`, or `not_followed`, at most at ten times or a tenth of the length or force
    """

    parameter: str
    from_: float
    to: float
    from_reason: Event
    to_reason: Event


class FollowedData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion of any word, and its range.

    Attributes
    ----------
    word, ratio, periods, stability, velocity, phase_rad, time, trace, multipliers
        as of [families](#families)
    error_bounds
        bounds of `velocity`, `phase_rad` and `time`
    stable_range
        around the design point
    """

    word: str
    ratio: str
    periods: int
    stability: str
    velocity: Numbers
    phase_rad: Numbers
    time: Numbers
    trace: float | None
    multipliers: MultipliersData
    error_bounds: dict[str, SomeNumbers]
    stable_range: FollowedRange


class OnBottomData(ResultsBlock, frozen=True, kw_only=True):
    """The stable motion on a table whose margins are stated.

    Attributes
    ----------
    word, periods
        the motion: that reached from rest, if it has no rests, else a known one with the fewest impacts
    stable_ranges
        of each input but the length and the restitution at the top, around the design point, as `stable_range` of
        [motions from rest](#disturbances); the ends are located to 1e-9 of their values
    """

    word: str
    periods: int
    stable_ranges: list[FollowedRange]


class OutcomeRangeData(ResultsBlock, frozen=True, kw_only=True):
    """Values of the swept parameter with one outcome from rest.

    Attributes
    ----------
    from_, to : as in the scenario
        the interval
    outcome, word, periods
        as of `from_rest`
    """

    from_: float
    to: float
    outcome: str | None
    word: str | None
    periods: int | None


class FromRestData(ResultsBlock, frozen=True, kw_only=True):
    """What the device comes to when it is switched on.

    `share_of_switch_on_phases`, `ramp_that_reaches_1_1`, `window` and `proved` are of additions, which have the records
    of their blocks: here is their place. Where an addition is out, its keys are.

    Attributes
    ----------
    outcome
        for a ball that lies on the bottom membrane when the force sets in: `reaches_1_1`, `other_motion`,
        `rest_cycle` (it rests on a membrane again and again), `chaotic` (irregular for some 1,600 impacts; of 312
        random devices with this outcome, 57 settled within 300,000 impacts), `at_rest`, or `undecided` where rounding
        decides; null where it is not looked for
    word, periods
        the motion and its forcing periods; a tilde marks ever lower hops and the rest that follows. Null where there
        are none, or a rest cycle is so long that rounding decides when it ends
    reason
        null, or what the outcome `undecided` comes of, in words
    settles_after_periods
        forcing periods from the moment the ball first leaves the membrane until its impacts stay within 1 % of that
        motion; null where they do not
    ramp_periods
        forcing periods over which the amplitude is ramped up; 0: at once
    motion
        a periodic motion of another word, without rests, that is reached from rest, solved from its equations; null
        unless no 1:1 motion is stable or there is a `disturbances:` block
    share_of_switch_on_phases
        share of the switch-on moments of a period from which 1:1 motion is reached, from 32 of them; exact for those
        at which the ball is pressed down; null without a `disturbances:` block
    ramp_that_reaches_1_1
        a ramp, where switching on does not reach a stable 1:1 motion; else null
    window
        the interval around the design point in which no change of the outcome was found; null where it is not looked
        for. [How it is searched](#the-window)
    along_sweep
        intervals of the sweep with one outcome, found with 201 values and bisection: narrower ones are missed. By
        default, without a design point and with no stable 1:1 motion in the sweep, only five values, each with `from`
        equal to `to`
    proved
        with `disturbances.prove`, whether it is [proved](model.md#proofs) that a ball that is pressed down when the
        force sets in reaches this motion; else null
    """

    outcome: str | None
    word: str | None = None
    periods: int | None = None
    reason: str | None = None
    settles_after_periods: float | None = None
    ramp_periods: float | None = None
    motion: FollowedData | None = None
    share_of_switch_on_phases: float | UnsetType | None = UNSET
    ramp_that_reaches_1_1: ResultsBlock | UnsetType | None = UNSET
    window: ResultsBlock | UnsetType | None = UNSET
    along_sweep: list[OutcomeRangeData] = []
    proved: bool | UnsetType | None = UNSET


class ShockData(ResultsBlock, frozen=True, kw_only=True):
    """The least shock that leads out of a stable 1:1 motion of the design point.

    It is of an addition, and is here as comparisons read it.

    Attributes
    ----------
    least_jump_m_s : m/s
        size of that jump of the relative velocity; null if none of those tried leads out. This is evidence, not
        proof: a smaller jump that was not tried may lead out
    after, after_s : –, s
        the membrane that the ball struck last (`bottom` or `top`), and the time since; null without a jump
    sign
        1 for a jump towards the bottom, −1 towards the top; null without a jump
    leads_to
        what the device does after a jump just above this size; null without a jump
    searched_to_m_s, tried : m/s, –
        if none leads out, the size up to which jumps were tried (the largest impact velocity of these motions, or the
        required size if that is larger), and their number
    reason
        why the other values are null: next to a critical point, it cannot be decided in reasonable time which jumps
        return
    proved_m_s : m/s
        with `disturbances.prove`, the size up to which all jumps, at any moment and in either direction, are
        [proved](model.md#proofs) to die out, rounded down to four digits; else null
    """

    least_jump_m_s: float | None = None
    after: str | None = None
    after_s: float | None = None
    sign: int | None = None
    leads_to: str | None = None
    searched_to_m_s: float | None = None
    tried: int | None = None
    reason: str | None = None
    proved_m_s: float | UnsetType | None = UNSET


class DisturbancesData(ResultsBlock, frozen=True, kw_only=True):
    """What the device does when it is switched on, and how fast it recovers.

    `shock`, `jitter`, `coexistence`, `basin` and `proof` are of additions, as in `FromRestData`.

    Attributes
    ----------
    from_rest
        what comes of switching on; null without a design point and a sweep
    found_by_starts
        stable motions that random starts in flight reach, as `from_rest.motion`; given if no 1:1 motion is stable and
        no periodic motion is reached from rest. With a `disturbances:` block, all that 64 starts of 256 impacts
        reach; without one, the first that 6 starts of 48 impacts reach. There may be others. Above a table all with one
        impact come first, from their formulae for a sine, whatever is reached from rest
    recovery_periods, recovery_s
        forcing periods and seconds until 1 % is left of a small disturbance of the slowest stable 1:1 motion, ln
        100/(−ln of the multiplier's modulus); null as `recovery_reason` says
    recovery_error_bound_periods
        error bound of `recovery_periods`
    recovery_reason
        null, or why there is no `recovery_periods`: no 1:1 motion is stable, or it may just be at the end of its
        stability
    shock
        the [least shock](model.md#shocks-and-jitter) that leads out of one of the stable 1:1 motions at the design
        point; null without a `disturbances:` block, without numba, and if no motion is stable
    jitter
        spread of the stable 1:1 motion whose phases spread most, under random kicks, `disturbances.jitter_m_s`, and a
        scatter of the restitution, `disturbances.jitter_restitution`; null where these are not given
    coexistence
        the known stable motions of any word at the design point: the 1:1 motions, those of `motions:` if the design
        point is within the sweep, and the one reached from rest; null without numba, and if neither a `disturbances:`
        block nor a required word asks for it
    basin
        with `disturbances.basin`, the section of impacts on the bottom membrane, over phase and velocity just before
        impact; else null
    proof
        what is needed to verify [the proofs](#the-proofs); null if none was asked for
    """

    from_rest: FromRestData | None = None
    found_by_starts: list[FollowedData] = []
    shock: ShockData | UnsetType | None = UNSET
    recovery_periods: float | None = None
    recovery_s: float | None = None
    recovery_error_bound_periods: float | None = None
    recovery_reason: str | None = None
    jitter: ResultsBlock | UnsetType | None = UNSET
    coexistence: ResultsBlock | UnsetType | None = UNSET
    basin: ResultsBlock | UnsetType | None = UNSET
    proof: ResultsBlock | UnsetType | None = UNSET


class MeasuredImpact(ResultsBlock, frozen=True, kw_only=True):
    """A measured impact beside the computed one: each quantity, its standard error, and how far they differ.

    Attributes
    ----------
    membrane
        which one it is on
    velocity, velocity_m_s : F π/(M ω), m/s
        relative velocity before the impact
    velocity_after, velocity_after_m_s : F π/(M ω), m/s
        relative velocity after it; null where it is not known
    phase_rad : rad
        phase of the force
    flight_t_c : half a forcing period
        the flight after it
    velocity_standard_error, velocity_m_s_standard_error, phase_rad_standard_error
        standard errors
    velocity_after_standard_error, velocity_after_m_s_standard_error, flight_t_c_standard_error
        standard errors
    velocity_computed, velocity_m_s_computed, phase_rad_computed
        of the computed motion; null where nothing was computed
    velocity_after_computed, velocity_after_m_s_computed, flight_t_c_computed
        of the computed motion; null where nothing was computed
    velocity_difference, velocity_m_s_difference, phase_rad_difference
        measured less computed, in standard errors; null where nothing was computed
    velocity_after_difference, velocity_after_m_s_difference, flight_t_c_difference
        measured less computed, in standard errors; null where nothing was computed
    """

    membrane: str
    velocity: float
    velocity_standard_error: float
    velocity_computed: float | None = None
    velocity_difference: float | None = None
    velocity_after: float | None = None
    velocity_after_standard_error: float | None = None
    velocity_after_computed: float | None = None
    velocity_after_difference: float | None = None
    phase_rad: float
    phase_rad_standard_error: float
    phase_rad_computed: float | None = None
    phase_rad_difference: float | None = None
    flight_t_c: float
    flight_t_c_standard_error: float
    flight_t_c_computed: float | None = None
    flight_t_c_difference: float | None = None
    velocity_m_s: float
    velocity_m_s_standard_error: float
    velocity_m_s_computed: float | None = None
    velocity_m_s_difference: float | None = None
    velocity_after_m_s: float | None = None
    velocity_after_m_s_standard_error: float | None = None
    velocity_after_m_s_computed: float | None = None
    velocity_after_m_s_difference: float | None = None


class MeasuredData(ResultsBlock, frozen=True, kw_only=True):
    """What was measured at one value of the swept parameter.

    Attributes
    ----------
    file, sha256, from_s, to_s, rows
        the record, and its times and rows
    sweep_value, direction
        value of the swept parameter, and `up`, `down` or null
    clock_referenced
        whether the phase of the force was given; else it was fitted
    timing_error_s, missed, false
        standard deviation of the errors of the times, and the numbers of missed and false impacts; null where nothing
        fits
    word, periods, settled_from_s, averaged
        the motion, the time from which it is periodic, and the number of impacts in the means; null without a word
    reason
        why there is no word; else null
    computed_motion, largest_difference
        the motion that the device reaches from the last measured state, and the largest difference from it in
        standard errors; null where nothing was computed
    impacts
        of each impact of the word
    trace, trace_standard_error
        of the linearised return map at a measured 1:1 motion; null where there is none
    """

    file: str = ""
    sha256: str = ""
    sweep_value: float
    direction: str | None = None
    from_s: float | None = None
    to_s: float | None = None
    rows: int | None = None
    clock_referenced: bool | None = None
    reason: str | None = None
    timing_error_s: float | None = None
    missed: int | None = None
    false: int | None = None
    word: str | None
    periods: int | None
    computed_motion: str | None = None
    largest_difference: float | None = None
    settled_from_s: float | None = None
    averaged: float | None = None
    impacts: list[MeasuredImpact] = []
    trace: float | None = None
    trace_standard_error: float | None = None


class MeasuredHysteresis(ResultsBlock, frozen=True, kw_only=True):
    """A value at which the motion depended on the direction in which the swept parameter came to it.

    Attributes
    ----------
    sweep_value
        value of the swept parameter
    up, down
        the words, which differ
    """

    sweep_value: float
    up: str
    down: str


class AlertData(ResultsBlock, frozen=True, kw_only=True):
    """An alert.

    Attributes
    ----------
    code
        such as VR011; `vireport explain` has the details
    severity
        `error` (the numbers are physically impossible, and no verdict is good), `warning` or `note`
    title, cause, remedy
        in words
    """

    code: str
    severity: str
    title: str
    cause: str = ""
    remedy: str = ""


class LeftOutData(ResultsBlock, frozen=True, kw_only=True):
    """A step that was not done, and why.

    Attributes
    ----------
    step, what, why
        its name, what it is, and why it was left out
    """

    step: str
    what: str
    why: str


class HarmonicKeys(ResultsBlock, frozen=True, kw_only=True):
    """A harmonic of the force, as a scenario states it."""

    order: int
    percent: float
    phase_deg: float


class DeviceKeys(ResultsBlock, frozen=True, kw_only=True):
    """The device of a scenario, as far as results are compared by it."""

    capsule_mass_kg: float
    restitution: Any = None
    length_m: float | None = None
    capsule: CapsuleMotion = CapsuleMotion.PRESCRIBED
    ball_mass_kg: float | None = None
    friction: float = 0.0


class ExcitationKeys(ResultsBlock, frozen=True, kw_only=True):
    """The force of a scenario."""

    amplitude_n: float | None = None
    frequency_hz: float | None = None
    harmonics: list[HarmonicKeys] = []


class SweepKeys(Range, frozen=True, kw_only=True):
    """The sweep of a scenario."""

    parameter: Parameter


class ScenarioKeys(ResultsBlock, frozen=True, kw_only=True):
    """What comparisons read of the block `scenario`, of which `scenario.blocks` has all keys."""

    device: DeviceKeys
    excitation: ExcitationKeys
    gravity_m_s2: float
    inclination_deg: float | None = None
    period_ratio: int = 1
    sweep: SweepKeys | None = None


class Results(ResultsBlock, frozen=True, kw_only=True):
    """Results of a run: results.json without its provenance.

    `added` are the blocks of additions to a study by their keys, in whose place they are written.

    Attributes
    ----------
    schema_version
        1
    scenario
        the scenario as understood, with defaults filled in
    overrides
        values that `--set` replaced, as `path=value`
    branches
        [the motions along the sweep](#branches), a block for each branch
    critical_points
        [the points](#critical-points) that divide the branches
    design_point
        [every motion at the design point, and its margins](#design-point-and-stable-ranges); null without one
    stable_range
        [ranges](#design-point-and-stable-ranges) of the swept parameter with stable admissible motion
    shaker
        [demands on the shaker](#shaker-and-membranes)
    fits_membrane
        where the deepest deflection exceeds the active radius, [changes that would each bring it
        within](#shaker-and-membranes); else null
    stretch
        how far the deepest impact of the stable 1:1 motions, at the design point or without one over the sweep,
        [stretches a membrane](#shaker-and-membranes); null without such a motion or ball mass
    table_1
        [the paper's Table 1](#table-1) for this scenario
    simulation
        [cross-check, shares of starts, sampled motions](#simulation); null where nothing was simulated
    motions
        [the limits of the motions that are looked for, and how completely they are found](#families); null without a
        `motions:` block
    families
        [families of motions of other impact sequences](#families); null without a `motions:` block
    own_stiffness
        [the motion and its ends with the membranes' own stiffness](#long-contacts), where contacts are long; else
        null
    effects
        [how far effects that the model neglects would move the nearest end of stable motion](#effects); null without
        a design point
    margin_to_use
        [the least margin](#effects) that rigid impacts, soft membranes and neglected effects leave; null without a
        design point, or an end
    on_bottom
        the stable motion on a table at the design point, and [how far each input can go](#effects) before it ends;
        absent where the top is within reach, and without a design point or such a motion
    added
        those of additions: `certificates`, [proven enclosures](#proved-critical-points); `accuracy`, [error against run
        time](#error-against-run-time); `compliant`, [the motion with compliant membranes](#compliant-membranes);
        `driven`, [what it does under a recorded acceleration](#driven-by-a-record); `escape`, [how long motions last
        under kicks](escape.md), where that is asked for; `tolerances`, [whether every device within the tolerances
        works](#tolerances), and the yield
    requirements
        [the acceptance table](#requirements-and-alerts); null without requirements
    disturbances
        [what it does when it is switched on and disturbed](#disturbances); null where there is neither a design point
        nor a sweep with a `disturbances:` block
    measured
        [records of impacts](#measured), an entry for each value of the swept parameter; absent without any
    measured_hysteresis
        [values at which the measured words depend on the direction](#measured); absent without records
    alerts
        [what to beware of](#requirements-and-alerts)
    left_out
        [every step that was not done](#requirements-and-alerts)
    """

    schema_version: int
    scenario: dict[str, Any]
    overrides: list[str] = []
    branches: list[BranchData]
    critical_points: list[CriticalPointData]
    design_point: DesignData | None
    stable_range: list[StableRangeData]
    shaker: ShakerData | None = None
    fits_membrane: FittingData | None = None
    stretch: StretchData | None = None
    table_1: list[TableRowData] = []
    simulation: SimulationData | None = None
    motions: MotionsData | None = None
    families: list[FamilyData] | None = None
    own_stiffness: OwnStiffnessData | None = None
    effects: EffectsData | None = None
    margin_to_use: MarginToUseData | None = None
    on_bottom: OnBottomData | UnsetType = UNSET
    added: AddedBlocks = field(default_factory=dict, name=ADDED)
    requirements: RequirementsData | None = None
    disturbances: DisturbancesData | None = None
    measured: list[MeasuredData] | UnsetType = UNSET
    measured_hysteresis: list[MeasuredHysteresis] | UnsetType = UNSET
    alerts: list[AlertData]
    left_out: list[LeftOutData] = []


def blocks_of(results: ResultsBlock) -> dict[str, object]:
    """Blocks of a file of results by their keys, those of additions in their place."""
    blocks: dict[str, object] = {}
    for key, block in keyed(results).items():
        blocks |= block if key == ADDED else {key: block}
    return blocks
