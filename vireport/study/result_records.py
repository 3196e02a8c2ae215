"""Records of results.json: what is written and what is read, with the names that scripts rely on.

A key without a default has been written by every version. One with a default may be missing: earlier versions, or a
run that had no use for it, do not write it. Keys that are not declared are passed over where a file is read.
"""

from __future__ import annotations

from typing import Any, ClassVar

from msgspec import UNSET, Struct, UnsetType, field

from vireport.base.records import brief, keyed
from vireport.motions.events import Event
from vireport.motions.stability import Stability
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter

SCHEMA_VERSION = 1

ADDED = "*"
"""Stands for the keys of additions to a study among those of `Results`."""

Numbers = list[float]
SomeNumbers = list[float | None]
"""Null where a number does not exist or is beyond the range of doubles."""

Bounds = dict[str, list[float | None] | str]
"""Error bounds by the names of columns, and under ``null_means`` why some are null."""


class ResultsBlock(Struct, frozen=True, kw_only=True, eq=False, rename={"from_": "from", "yield_": "yield"}):
    """A block of keys of results.json."""

    __repr__ = brief


class Range(ResultsBlock, frozen=True, kw_only=True):
    """A range of an input, from one value to the other."""

    from_: float
    to: float


MOTION_COLUMNS = (
    *("sweep_value", "d", "gbar", "q", "phi_bottom_rad", "phi_top_rad", "velocity_bottom", "velocity_top"),
    *("trace", "determinant", "discriminant", "stability", "admissible", "wall_gap", "admissible_undecided"),
    *("u_bottom_v", "u_top_v", "u_ave_v", "deflection_m"),
)
"""Keys of a branch, and of a design point, that have a value for each motion."""


class BranchData(ResultsBlock, frozen=True, kw_only=True):
    """A branch of 1:1 motions: all but the first four and the bounds are arrays of equal length, along the curve."""

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
    """A 1:1 motion at a critical point."""

    q: float
    phi_bottom_rad: float
    velocity_bottom: float
    velocity_top: float
    error_bounds: dict[str, float | None] = {}


class CriticalPointData(ResultsBlock, frozen=True, kw_only=True):
    """A critical point, its 1:1 motion, and the mirror image of that where there is one."""

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
    """Derivatives by the cosine and the sine of a harmonic of the force, for one per cent of it."""

    cosine: float
    sine: float


class MarginData(ResultsBlock, frozen=True, kw_only=True):
    """A margin of the design point: the distance to a critical point when one input varies."""

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
    """Where a stable range would end if the sweep went on."""

    sweep_value: float
    kind: Event
    d: float
    gbar: float
    error_bound: float


class StableRangeData(ResultsBlock, frozen=True, kw_only=True):
    """A range of an input with stable admissible motion, and what ends it on either side."""

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
    """The least harmonic of an order that ends a stable motion of the design point; null without one."""

    order: int
    percent: float | None
    phase_deg: float | None
    kind: Event | None
    error_bound_percent: float | None
    searched_to_percent: float


class DesignData(ResultsBlock, frozen=True, kw_only=True):
    """The motions at the design point, as arrays of equal length, with margins and stable ranges."""

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
    """Demands on the shaker."""

    acceleration_amplitude_g: float | None
    acceleration_amplitude_m_s2: float | None
    velocity_amplitude_m_s: float | None
    stroke_m: float | None
    force_amplitude_n: float | None = None


class FittingData(ResultsBlock, frozen=True, kw_only=True):
    """Changes that would each keep the deepest deflection within the membrane's active radius."""

    ball_mass_at_most_kg: float | None
    stiffness_at_least: float | None
    active_radius_at_least_m: float | None


class StretchData(ResultsBlock, frozen=True, kw_only=True):
    """How far the deepest impact of the stable motions stretches a membrane; null beyond the range of doubles."""

    deflection_m: float | None
    deflection_over_radius: float | None
    area_ratio: float | None
    u_imp_v: float | None
    thickness_needed_m: float | None
    at_field_v_m: float | None


class TableRowData(ResultsBlock, frozen=True, kw_only=True):
    """A row of the paper's Table 1."""

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
    """What kind of motion it is; a word and a period are of periodic ones."""

    outcome: str
    word: str | None
    period: int | None


class CountedMotion(KindOfMotion, frozen=True, kw_only=True):
    """A kind of motion that starts end in, how many do, and between which values of the parameter."""

    count: int
    from_: float
    to: float


class MissData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion on which the simulation did not end."""

    sweep_value: float
    outcome: str


class BasinShares(ResultsBlock, frozen=True, kw_only=True):
    """The share of the starts that lead to a 1:1 motion, with its interval of 95 %."""

    trials: int
    reached: int
    share: float
    low_95: float
    high_95: float
    elsewhere: list[CountedMotion]


class StartEnd(KindOfMotion, frozen=True, kw_only=True):
    """What a start leads to; what a motion that is not periodic does not have is null."""

    residual: float | None
    multiplier: float | None
    lyapunov: float | None
    error_bounds: dict[str, float | None]


class SampleData(ResultsBlock, frozen=True, kw_only=True):
    """What the starts at one value of the parameter lead to."""

    sweep_value: float
    d: float
    start_velocity_at_most: float
    ends: list[StartEnd]


class StageData(ResultsBlock, frozen=True, kw_only=True):
    """The motion at a value of a sweep that is gone through slowly, with its impacts."""

    sweep_value: float
    outcome: str
    word: str | None
    period: int | None
    wall: list[int]
    phase_rad: SomeNumbers
    velocity: SomeNumbers


class VertexData(ResultsBlock, frozen=True, kw_only=True):
    """The critical point at which a motion ends before a jump."""

    label: str
    kind: Event
    sweep_value: float


class JumpData(ResultsBlock, frozen=True, kw_only=True):
    """A jump from one motion to another."""

    from_: float
    to: float
    before: KindOfMotion
    after: KindOfMotion
    vertex: VertexData | None


class CourseData(ResultsBlock, frozen=True, kw_only=True):
    """The motions at the values in their order, and the jumps between them."""

    samples: list[StageData]
    jumps: list[JumpData]


class LoopData(ResultsBlock, frozen=True, kw_only=True):
    """A range in which the motion depends on the direction of the sweep."""

    from_: float
    to: float
    width: float
    up: KindOfMotion
    down: KindOfMotion


class CoexistingData(KindOfMotion, frozen=True, kw_only=True):
    """A kind of motion, and the ranges in which it was found, by what found it."""

    up: list[list[float]] = []
    down: list[list[float]] = []
    starts: list[list[float]] = []
    families: list[list[float]] = []


class FollowData(ResultsBlock, frozen=True, kw_only=True):
    """What a sweep that is gone through slowly meets, upwards and downwards."""

    up: CourseData | None
    down: CourseData | None
    loops: list[LoopData]
    coexisting: list[CoexistingData]


class SimulationData(ResultsBlock, frozen=True, kw_only=True):
    """The cross-check by simulation."""

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
    """How completely the families of a word are found; a word of null is of all words that are not listed."""

    word: str | None
    claim: str
    resolution: float | None
    undecided: float | None


class MotionsData(ResultsBlock, frozen=True, kw_only=True):
    """The limits of the motions that are looked for, and how completely they are found."""

    impacts: int
    periods: int
    followed_impacts: int | None = None
    families_found: int | None = None
    completeness: list[CompletenessData] = []


class FamilyEnd(ResultsBlock, frozen=True, kw_only=True):
    """What a family begins or ends with."""

    kind: Event
    label: str | None
    families: list[int]
    sweep_value: float


class FamilyPoint(ResultsBlock, frozen=True, kw_only=True):
    """What happens to a motion of a family."""

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
    """Voltages and impacts of a motion of a family."""

    sweep_value: float
    u_impacts_v: SomeNumbers
    u_ave_v: float | None
    impacts_per_s: float | None
    u_per_second_v: float | None


class MultipliersData(ResultsBlock, frozen=True, kw_only=True):
    """MultipliersData of a motion, by their parts."""

    real: SomeNumbers
    imaginary: SomeNumbers


class MultipliersOfFamily(ResultsBlock, frozen=True, kw_only=True):
    """MultipliersData of every motion of a family, by their parts."""

    real: list[SomeNumbers]
    imaginary: list[SomeNumbers]


class FamilyBounds(ResultsBlock, frozen=True, kw_only=True):
    """Error bounds of the motions of a family."""

    sweep_value: SomeNumbers
    velocity: list[SomeNumbers]
    phase_rad: list[SomeNumbers]
    null_means: str = ""


class FamilyData(ResultsBlock, frozen=True, kw_only=True):
    """A family of motions of other impact sequences: from `sweep_value` on, arrays along the family."""

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
    """The motion with the membranes' stiffness."""

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
    """An end of stable motion, with rigid impacts and with the membranes' stiffness."""

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
    """The motion and its ends with the membranes' stiffness, where contacts are long."""

    parameter: str
    value: float
    at_design_point: bool
    margin_gone: bool
    motion: CompliantMotionData | None
    missing: str | None
    reason: str | None
    ends: list[CompliantEndData]


class EffectRow(ResultsBlock, frozen=True, kw_only=True):
    """Where the nearest end of stable motion is with an effect that the model leaves out."""

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
    """The nearest end of stable motion, and where it is with each effect that the model leaves out."""

    parameter: str | None
    label: str | None
    kind: Event | None
    sweep_value: float | None
    relative: float | None
    reason: str | None
    rows: list[EffectRow]


class MarginToUseData(ResultsBlock, frozen=True, kw_only=True):
    """The least margin that rigid impacts, soft membranes and neglected effects leave."""

    parameter: str
    relative: float | None
    limited_by: str
    effect: str | None
    change: float | None
    gone: bool


class CriterionData(ResultsBlock, frozen=True, kw_only=True):
    """A line of the acceptance table."""

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
    """The acceptance table, and whether all that is required is met."""

    passed: bool
    criteria: list[CriterionData]


class FollowedRange(ResultsBlock, frozen=True, kw_only=True):
    """The range of an input over which a motion exists and is stable, and what ends it."""

    parameter: str
    from_: float
    to: float
    from_reason: Event
    to_reason: Event


class FollowedData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion of any word, and its range."""

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


class OutcomeRangeData(ResultsBlock, frozen=True, kw_only=True):
    """Values of the swept parameter with one outcome from rest."""

    from_: float
    to: float
    outcome: str | None
    word: str | None
    periods: int | None


class FromRestData(ResultsBlock, frozen=True, kw_only=True):
    """What the device comes to when it is switched on.

    `share_of_switch_on_phases`, `ramp_that_reaches_1_1`, `window` and `proved` are of additions, which have the records
    of their blocks: here is their place. Where an addition is out, its keys are.
    """

    outcome: str | None
    word: str | None = None
    periods: int | None = None
    reason: str | None = None
    settles_after_periods: float | None = None
    ramp_periods: float | None = None
    motion: FollowedData | None = None
    share_of_switch_on_phases: float | UnsetType | None = UNSET
    ramp_that_reaches_1_1: Any = UNSET
    window: Any = UNSET
    along_sweep: list[OutcomeRangeData] = []
    proved: bool | UnsetType | None = UNSET


class ShockData(ResultsBlock, frozen=True, kw_only=True):
    """The least shock that leads out of a stable 1:1 motion of the design point; of additions, read by comparisons."""

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
    """

    from_rest: FromRestData | None = None
    found_by_starts: list[FollowedData] = []
    shock: ShockData | UnsetType | None = UNSET
    recovery_periods: float | None = None
    recovery_s: float | None = None
    recovery_error_bound_periods: float | None = None
    recovery_reason: str | None = None
    jitter: Any = UNSET
    coexistence: Any = UNSET
    basin: Any = UNSET
    proof: Any = UNSET


class MeasuredImpact(ResultsBlock, frozen=True, kw_only=True):
    """A measured impact beside the computed one: each quantity, its standard error, and how far they differ."""

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
    """What was measured at one value of the swept parameter."""

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
    """A value at which the motion depended on the direction in which the swept parameter came to it."""

    sweep_value: float
    up: str
    down: str


class AlertData(ResultsBlock, frozen=True, kw_only=True):
    """An alert."""

    code: str
    severity: str
    title: str
    cause: str = ""
    remedy: str = ""


class LeftOutData(ResultsBlock, frozen=True, kw_only=True):
    """A step that was not done, and why."""

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
    added: dict[str, Any] = field(default_factory=dict, name=ADDED)
    requirements: RequirementsData | None = None
    disturbances: DisturbancesData | None = None
    measured: list[MeasuredData] | UnsetType = UNSET
    measured_hysteresis: list[MeasuredHysteresis] | UnsetType = UNSET
    alerts: list[AlertData]
    left_out: list[LeftOutData] = []

    def blocks(self) -> dict[str, Any]:
        """Its blocks by their keys, those of additions in their place."""
        blocks: dict[str, Any] = {}
        for key, block in keyed(self).items():
            blocks |= block if key == ADDED else {key: block}
        return blocks
