"""What others have published of balls that strike moving membranes or tables, beside what this program computes.

Each source is a function of its own, which makes scenarios of the devices in print and has them analysed as any other.
A published number is compared to its last digit, a formula to double precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from csv import DictReader
from itertools import chain, groupby
from math import acos, asin, atan2, cos, hypot, inf, pi, sin, sqrt
from pathlib import Path

import numpy as np
from msgspec import Struct

from vireport.base.progress import Progress
from vireport.motions.events import Event
from vireport.motions.families import Atlas
from vireport.paper.reproduction import ReproducedPaper
from vireport.physics.energy import Membrane
from vireport.physics.motion import Motion, Symmetry
from vireport.report.printed import quantity_of
from vireport.scenario.loading import load
from vireport.study.checks.paper import PAPER, half_unit
from vireport.study.plan import Task
from vireport.study.study import Study, analyse
from vireport.text.formatting import ROUGHLY, exact, rounded_text
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

LISTED_MOTIONS = Path(__file__).parent / "listed_motions.csv"
"""Motions of a ball on a table, as `ORBITS` lists them."""

GRAVITY = 9.81
"""Of the balls on tables [m/s^2]."""

CEILING = 300.0
"""Length of their capsules [m], which no ball reaches: what is left is a table."""

FORMULA = 1e-12
"""Relative difference up to which a formula agrees: all digits but those that rounding takes."""

FORMULA_ROUNDED = 1e-10
"""Relative error of the value of a formula as it is printed."""

PASSES = 1e-6
"""Depth by which a listed motion passes through the table if it is none [m]: above what its digits leave open."""


class PublishedSource(Struct, frozen=True):
    """Where results are in print.

    Attributes
    ----------
    name : str
        Short, for a table.
    citation : str
    """

    name: str
    citation: str


THE_PAPER = PublishedSource("the paper", PAPER)
ORBITS = PublishedSource(
    "Church, Fortin",
    "K. E. M. Church, C. Fortin: Computer-assisted methods for analyzing periodic orbits in vibrating gravitational "
    "billiards (2020), with the lists of github.com/ClementFortin/BilliardOscillatingParabola",
)
BOUNCING = PublishedSource(
    "bouncing ball",
    "P. J. Holmes, J. Sound Vib. 84 (1982) 173-189; J. M. Luck, A. Mehta, Phys. Rev. E 48 (1993) 3988-3997; A. C. J. "
    "Luo, R. P. S. Han, Nonlinear Dynamics 10 (1996) 1-18",
)
COURSE = PublishedSource(
    "course FI3104B",
    "Course FI3104B of the Universidad de Chile, 2015, second assignment: github.com/uchileFI3104B-2015B/02Tarea",
)
SINK = PublishedSource(
    "energy sink",
    "T. Weidemann, L. A. Bergman, A. F. Vakakis, M. Krack: Energy transfer and localization in a forced cyclic chain "
    "of oscillators with vibro-impact nonlinear energy sinks, Nonlinear Dynamics (2025), "
    "doi 10.1007/s11071-025-10928-4",
)
VOLTAGE = PublishedSource(
    "(5.2)-(5.5)",
    "L. Serdukova, R. Kuske, D. Yurchenko, Nonlinear Dynamics (2019), Eqs. (5.2)-(5.5), as in the program "
    "github.com/yashpermalla/TET_EH",
)
FIXED_STEPS = PublishedSource(
    "fixed steps",
    "The simulation of github.com/yashpermalla/TET_EH, by Runge-Kutta steps of fixed size h",
)
INELASTIC = PublishedSource(
    "Mehta, Luck",
    "A. Mehta, J. M. Luck: Novel temporal behavior of a nonlinear dynamical system: the completely inelastic bouncing "
    "ball, Phys. Rev. Lett. 65 (1990) 393-396",
)


class ValidatedNumber(Struct, frozen=True):
    """A published number, and ours.

    Attributes
    ----------
    published : str
        As it is shown, with the digits that it has.
    value : float
        What it stands for, in the unit of the result; of an interval the number that is nearest to ours.
    within : float
        Largest difference that its digits, or the way in which it was obtained, leave open.
    ours : float
    """

    published: str
    value: float
    within: float
    ours: float

    @classmethod
    def printed(cls, published: str, ours: float) -> ValidatedNumber:
        """A number in print, whose last digit is rounded."""
        return cls(published, float(published), half_unit(published), ours)

    @classmethod
    def between(cls, low: str, high: str, ours: float) -> ValidatedNumber:
        """A number of which an interval is in print."""
        return cls(f"{low} to {high}", min(max(ours, float(low)), float(high)), 0.0, ours)

    @classmethod
    def of_formula(cls, value: float, ours: float) -> ValidatedNumber:
        """The value of a formula in print."""
        return cls(rounded_text(value, FORMULA_ROUNDED * abs(value)), value, FORMULA * abs(value), ours)

    @property
    def computed(self) -> str:
        """Ours as text, with one digit more than is published."""
        return rounded_text(self.ours, half_unit(self.published.split()[-1]) / 10)

    @property
    def difference(self) -> float:
        """How far ours is from what is published."""
        return abs(self.ours - self.value)

    @property
    def agrees(self) -> bool:
        """Whether the difference is one that is left open."""
        return self.difference <= self.within


class ValidationRow(Struct, frozen=True):
    """A published result, and ours.

    Attributes
    ----------
    source : PublishedSource
    what : str
        The quantity with its unit, and the device.
    numbers : tuple of ValidatedNumber
        Of which the result consists, one or more.
    """

    source: PublishedSource
    what: str
    numbers: tuple[ValidatedNumber, ...]

    @property
    def published(self) -> str:
        """The published number, or how many there are."""
        return self.numbers[0].published if len(self.numbers) == 1 else f"{len(self.numbers)} numbers"

    @property
    def computed(self) -> str:
        """Our number, or how many of ours agree."""
        agreeing = sum(number.agrees for number in self.numbers)
        return self.numbers[0].computed if len(self.numbers) == 1 else f"{agreeing} agree"

    @property
    def difference(self) -> float:
        """Largest difference of any of its numbers."""
        return max(number.difference for number in self.numbers)

    @property
    def agrees(self) -> bool:
        """Whether all its numbers agree."""
        return all(number.agrees for number in self.numbers)


def validate(say: Progress = lambda what: None) -> tuple[ValidationRow, ...]:
    """Compute what others have published, and compare.

    Parameters
    ----------
    say : callable
        Told each source as it begins.

    Returns
    -------
    tuple of ValidationRow
        By their sources.
    """
    rows: list[ValidationRow] = []
    for source, results in RESULTS:
        say(f"computing what is in print: {source.name}")
        rows += (ValidationRow(source, what, compared) for what, compared in results())
    return tuple(rows)


def paper_rows(paper: ReproducedPaper) -> Iterator[ValidationRow]:
    """What the paper itself prints, and ours; within what the rounding of its inputs and of its digits leaves open."""
    for one in paper.compared:
        for row in one.rows:
            if row.printed:
                within = row.gap if row.agrees else 0.0
                what = quantity_of(row, one.case.panels).words()
                number = ValidatedNumber(row.printed, float(row.printed), within, row.ours)
                yield ValidationRow(THE_PAPER, what, (number,))


def validation_table(rows: Sequence[ValidationRow], templates: Path | None = None) -> Table:
    """Published results beside ours, a row for each, in the order of the rows.

    Parameters
    ----------
    rows : sequence of ValidationRow
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    say, agreeing = Words("reproduction", templates), sum(row.agrees for row in rows)
    cells = (
        (
            row.source.name,
            row.what,
            row.published,
            row.computed,
            rounded_text(row.difference, ROUGHLY),
            say("agrees" if row.agrees else "misprint" if row.source is THE_PAPER else "differs"),
        )
        for row in rows
    )
    return worded_table(say, "validation", "ttnnnt", cells, agreeing, len(rows))


Result = tuple[str, tuple[ValidatedNumber, ...]]
"""A quantity, and its numbers."""


def _table(restitution: float, swept: dict[str, object], limits: tuple[int, int], **excitation: float) -> Atlas:
    """The motions of a ball on a table that vibrates at 1 Hz.

    Parameters
    ----------
    restitution : float
    swept : dict
        The block `sweep`.
    limits : tuple of int
        Impacts and periods of a motion.
    **excitation : float
        Amplitude of the force on a mass of 1 kg, `amplitude_n`, unless it is swept.
    """
    device = {"capsule_mass_kg": 1.0, "restitution": restitution}
    study = _study(
        {
            "device": device if swept["parameter"] == "length_m" else device | {"length_m": CEILING},
            "excitation": {"frequency_hz": 1.0, **excitation},
            "inclination_deg": 90.0,
            "gravity_m_s2": GRAVITY,
            "motions": {"impacts": limits[0], "periods": limits[1]},
            "sweep": swept,
        }
    )
    assert study.atlas is not None  # of a scenario with a block `motions`
    return study.atlas


def _study(scenario: dict[str, object]) -> Study:
    return analyse(load({"schema_version": 1, **scenario}), (Task.JSON,))


def _over_acceleration(low: float, high: float) -> dict[str, object]:
    """A sweep over the amplitude of the table's acceleration, in units of gravity."""
    return {"parameter": "amplitude_n", "from": low * GRAVITY, "to": high * GRAVITY}


def _listed_motions() -> Iterator[Result]:
    """Impacts of the listed motions of a ball on a table, by lists."""
    lines = LISTED_MOTIONS.read_text(encoding="utf-8").splitlines()
    for name, rows in groupby(DictReader(line for line in lines if not line.startswith("#")), lambda row: row["list"]):
        listed = list(rows)
        restitution, amplitude = float(listed[0]["restitution"]), float(listed[0]["amplitude_m"])
        force = (2 * pi) ** 2 * amplitude
        swept = {"parameter": "length_m", "from": 0.9 * CEILING, "to": 1.1 * CEILING}
        limits = 2, max(int(row["periods"]) for row in listed)
        motions = [motion for _, motion in _table(restitution, swept, limits, amplitude_n=force).at(CEILING)]
        ours = [impacts for motion in motions for impacts in _impacts_on_table(motion, amplitude)]
        passing = [row for row in listed if _passes_through(row)]
        compared = [_nearest(row, ours) for row in listed if row not in passing]
        impacts = tuple(chain.from_iterable(compared))
        yield f"t [s] and w [m/s] of {len(compared)} motions, list {name}", impacts
        if passing:
            none = sum(not all(number.agrees for number in _nearest(row, ours)) for row in passing)
            count = ValidatedNumber(str(len(passing)), len(passing), 0, none)
            yield "more in that list, which pass through the table: no motions", (count,)


IMPACTS = "t0_s", "w0_m_s", "t1_s", "w1_m_s"
"""Time of each impact, and upward velocity of the ball before it."""


def _impacts_on_table(motion: Motion, amplitude: float) -> Iterator[tuple[int, tuple[float, ...]]]:
    """Periods and impacts of a motion with two impacts, or of two periods of one with one, from either impact on."""
    if len(motion.word) > 2:
        return
    pair = motion.times(2 // len(motion.word))
    for start in (pair, pair.rotated(1)):
        # The force is a cosine and the height of the table a sine, of opposite sign; the unit of time is half a period.
        times = start.time / 2 - 1 / 4
        speeds = 2 * pi * amplitude * np.cos(2 * pi * times) - 2 * pi**2 * amplitude * start.velocity
        first, second = (times - np.floor(times[0])).tolist()
        yield pair.word.periods, (first, float(speeds[0]), second, float(speeds[1]))


def _nearest(row: dict[str, str], ours: list[tuple[int, tuple[float, ...]]]) -> tuple[ValidatedNumber, ...]:
    """The impacts of a listed motion beside those of the nearest of ours."""
    listed = [float(row[name]) for name in IMPACTS]
    alike = [impacts for periods, impacts in ours if periods == int(row["periods"])]
    nearest = min((*alike, 4 * (inf,)), key=lambda impacts: float(np.abs(np.subtract(impacts, listed)).max()))
    return tuple(ValidatedNumber.printed(row[name], number) for name, number in zip(IMPACTS, nearest, strict=True))


def _passes_through(row: dict[str, str]) -> bool:
    """Whether the ball of a listed motion is below the table between its impacts, by the listed numbers alone."""
    restitution, amplitude = float(row["restitution"]), float(row["amplitude_m"])
    t0, w0, t1, w1 = (float(row[name]) for name in IMPACTS)
    for start, end, velocity in ((t0, t1, w0), (t1, t0 + int(row["periods"]), w1)):
        after = (1 + restitution) * 2 * pi * amplitude * cos(2 * pi * start) - restitution * velocity
        time = np.linspace(0, end - start, 2000)
        height = amplitude * (np.sin(2 * pi * start) - np.sin(2 * pi * (start + time)))
        if (height + after * time - GRAVITY / 2 * time**2).min() < -PASSES:
            return True
    return False


WORDS_B = (0.15, 1), (0.3, 1), (0.5, 1), (0.8, 1), (0.8, 2), (0.9, 3)
"""Restitution and periods of motions with one impact."""


def _one_impact() -> Iterator[Result]:
    """Where motions with one impact begin and where their period doubles."""
    for restitution, periods in WORDS_B:
        onset = periods * pi * (1 - restitution) / (1 + restitution)
        doubling = hypot(onset, 2 * (1 + restitution**2) / (1 + restitution) ** 2)
        yield from _onset_and_doubling(restitution, periods, onset, doubling)


def _inelastic() -> Iterator[Result]:
    """Onset and doubling of a ball that does not rebound: where the table presses on it, it does not leave at once."""
    yield from _onset_and_doubling(0.0, 1, sqrt(1 + pi**2), sqrt(pi**2 + 4))


def _onset_and_doubling(restitution: float, periods: int, onset: float, doubling: float) -> Iterator[Result]:
    """Both values of Gamma, the amplitude of the table's acceleration over gravity, and those of our family."""
    motions = _table(restitution, _over_acceleration(onset - 0.1, doubling + 0.1), (1, periods))
    (family,) = (family for family in motions.families if family.word.periods == periods)
    points = [mark.point for mark in family.marks if mark.point is not None]
    (doubled,) = (point.sweep_value for point in points if point.event is Event.PERIOD_DOUBLING)
    begins = min(point.sweep_value for point in points)
    ball = f"r = {exact(restitution)}, n = {periods}"
    yield f"Γ of onset, {ball}", (ValidatedNumber.of_formula(onset, begins / GRAVITY),)
    yield f"Γ of doubling, {ball}", (ValidatedNumber.of_formula(doubling, doubled / GRAVITY),)


COURSE_RESTITUTION = 0.15
COURSE_INTERVALS = ("1.6700", "1.6705"), ("1.7295", "1.7305"), ("1.7425", "1.7440")
"""Of the angular frequency, with amplitude and gravity 1."""


def _course() -> Iterator[Result]:
    """The first doublings of a cascade."""
    motions = _table(COURSE_RESTITUTION, _over_acceleration(1.66**2, 1.75**2), (4, 4))
    doublings = sorted(point.sweep_value for point in motions.vertices if point.event is Event.PERIOD_DOUBLING)
    for count, (value, interval) in enumerate(zip(doublings, COURSE_INTERVALS, strict=True), 1):
        compared = ValidatedNumber.between(*interval, sqrt(value / GRAVITY))
        yield f"ω of doubling {count}, r = {exact(COURSE_RESTITUTION)}", (compared,)


CAPSULE, PAPER_RESTITUTION = 0.1245, 0.5
"""Mass of the capsule [kg] and restitution of the paper's device."""


class ValidatedDevice(Struct, frozen=True):
    """A device with two membranes.

    Attributes
    ----------
    name : str
    inclination_deg, amplitude_n, frequency_hz : float
    d : float
        Dimensionless length.
    restitution : float
    readings : tuple of str
        Velocity at the bottom [y_c] by fixed steps of each of `STEPS`; () where there are none.
    """

    name: str
    inclination_deg: float
    amplitude_n: float
    frequency_hz: float
    d: float
    restitution: float = PAPER_RESTITUTION
    readings: tuple[str, ...] = ()

    @property
    def velocity_unit(self) -> float:
        """y_c = F pi/(M omega) [m/s]."""
        return self.amplitude_n / (2 * CAPSULE * self.frequency_hz)

    @property
    def length_m(self) -> float:
        """Length of the capsule, d F/(4 M f^2) [m]."""
        return self.d * self.amplitude_n / (4 * CAPSULE * self.frequency_hz**2)

    def study(self, **more: object) -> Study:
        """The study of the 1:1 motions of the device, with more blocks."""
        device = {"capsule_mass_kg": CAPSULE, "restitution": self.restitution, "ball_mass_kg": BALL}
        return _study(
            {
                "device": device | ({} if "sweep" in more else {"length_m": self.length_m}),
                "excitation": {"amplitude_n": self.amplitude_n, "frequency_hz": self.frequency_hz},
                "inclination_deg": self.inclination_deg,
                **more,
            }
        )


BALL = 0.2 * CAPSULE
"""Mass of the ball in the voltages of `VOLTAGE` [kg]."""

STEPS = 1e-3, 1e-4
"""Steps of `FIXED_STEPS` [t_c]."""

DEVICES = (
    ValidatedDevice("Fig. 3(a)", 0.0, 3.0, 2.0, 0.3688, readings=("0.71483", "0.715218")),
    ValidatedDevice("Fig. 3(c)", 45.0, 3.0, 2.0, 0.4604, readings=("1.00366", "1.003966")),
    ValidatedDevice("30°, F = 5 N, f = 2.5 Hz", 30.0, 5.0, 2.5, 0.3735, readings=("0.80228", "0.802687")),
)
"""Those of Fig. 3 (a) and (c) of the paper, and one at 30 degrees."""


def _voltages() -> Iterator[Result]:
    """U_ave of all motions of three devices."""
    for device in DEVICES:
        study = device.study()
        design, membrane = study.solution.design, study.solution.membrane
        assert design is not None  # of a scenario with a length
        assert design.voltages_by_motion is not None  # and a mass of the ball
        assert membrane is not None
        motions = zip(design.motions.velocity_bottom, design.motions.velocity_top, strict=True)
        for speeds, ours in zip(motions, design.voltages_by_motion.average_v, strict=True):
            gains = [voltage_by_tangent(abs(float(speed)) * device.velocity_unit, membrane) for speed in speeds]
            at_bottom = rounded_text(float(speeds[0]))
            yield (
                f"U_ave [V], {device.name}, Ż = {at_bottom}",
                (ValidatedNumber.of_formula(sum(gains) / 2, float(ours)),),
            )


def voltage_by_tangent(speed: float, membrane: Membrane) -> float:
    """Voltage gained at an impact [V], of Eqs. (5.2) and (5.5), with the area by the tangent from the rim to the ball.

    Parameters
    ----------
    speed : float
        Relative speed just before it [m/s].
    membrane : Membrane

    Notes
    -----
    The centre of the ball is c = delta - rb below the rim. The line from the rim to it, of length l, descends by
    atan2(c, Rc); the membrane, tangent to the ball, by a further asin(rb/l). Its area is that of a cone of slant height
    sqrt(l^2 - rb^2) and of a cap on the ball.
    """
    power, rim, ball = membrane.exponent + 1, membrane.active_radius_m, membrane.ball_radius_m
    depth = (power * membrane.ball_mass_kg * speed**2 / (2 * membrane.stiffness)) ** (1 / power)
    line = hypot(rim, depth - ball)
    angle = atan2(depth - ball, rim) + asin(ball / line)
    cone = pi * (rim + ball * sin(angle)) * sqrt(line**2 - ball**2)
    cap = 2 * pi * ball**2 * (1 - cos(angle))
    return membrane.bias_voltage_v * (((cone + cap) / (pi * rim**2)) ** 2 - 1)


def _fixed_steps() -> Iterator[Result]:
    """Velocity at the bottom of the stable motion of three devices, by steps that stop short of the impact."""
    for device in DEVICES:
        design = device.study().solution.design
        assert design is not None  # of a scenario with a length
        velocity = float(design.motions.velocity_bottom[0])
        gravity = float(design.motions.gbar[0])
        for step, reading in zip(STEPS, device.readings, strict=True):
            # Up to a step before the impact, in which the velocity changes by at most the step times 1 + gbar.
            compared = ValidatedNumber(reading, float(reading), (1 + gravity) * step, velocity)
            yield f"Ż at the bottom [y_c], {device.name}, h = {exact(step)}", (compared,)


SINK_RESTITUTIONS, AMPLITUDES = (0.5, 0.65, 0.8, 0.9), (0.4, 1.5)
"""Of the energy sinks, and amplitudes xi of the host over half the clearance: two motions at the first, one at the
second."""


def _energy_sink() -> Iterator[Result]:
    """The slow invariant manifold of an energy sink, whose host moves as our horizontal capsule does.

    Notes
    -----
    With the amplitudes theta of the absorber and xi of the host over half the clearance, an angle Delta between them
    and rho = 2 (1-r)/(pi (1+r)), it is theta - 1 = xi cos(Delta) and rho theta = xi sin(Delta). Ours has
    xi = 2/(pi^2 d), theta = (1+r) Zd/(2 d) and Delta = phi.
    """
    for restitution in SINK_RESTITUTIONS:
        rho = 2 / pi * (1 - restitution) / (1 + restitution)
        sink = f"r = {exact(restitution)}"
        compared: list[ValidatedNumber] = []
        for xi in AMPLITUDES:
            ours = _symmetric(ValidatedDevice(sink, 0.0, 3.0, 2.0, 2 / (pi**2 * xi), restitution))
            root = sqrt((1 + rho**2) * xi**2 - rho**2)
            for theta in ((1 + root) / (1 + rho**2), (1 - root) / (1 + rho**2)):
                if theta > 0:
                    pair = min((*ours, (inf, inf)), key=lambda motion: abs(motion[0] - theta))
                    published = theta, acos((theta - 1) / xi)
                    compared += map(ValidatedNumber.of_formula, published, pair)
        yield f"θ and Δ of {len(compared) // 2} motions, {sink}", tuple(compared)
        fold = rho / sqrt(1 + rho**2)
        device = ValidatedDevice(sink, 0.0, 3.0, 2.0, 2 / (pi**2 * fold), restitution)
        ends = {"from": 0.9 * device.length_m, "to": 1.1 * device.length_m}
        points = device.study(sweep={"parameter": "length_m", **ends}).solution.critical_points
        (turning,) = (point for point in points if point.event is Event.FOLD)
        yield f"ξ of the fold, {sink}", (ValidatedNumber.of_formula(fold, 2 / (pi**2 * turning.d)),)


def _symmetric(device: ValidatedDevice) -> list[tuple[float, float]]:
    """Theta and Delta of each symmetric motion of a horizontal capsule."""
    design = device.study().solution.design
    assert design is not None  # of a scenario with a length
    rows = [row for row, family in enumerate(design.families) if family is Symmetry.SYMMETRIC]
    theta = (1 + device.restitution) * design.motions.velocity_bottom / (2 * device.d)
    return [(float(theta[row]), float(design.motions.phi_bottom[row])) for row in rows]


RESULTS: tuple[tuple[PublishedSource, Callable[[], Iterator[Result]]], ...] = (
    (ORBITS, _listed_motions),
    (BOUNCING, _one_impact),
    (INELASTIC, _inelastic),
    (COURSE, _course),
    (SINK, _energy_sink),
    (VOLTAGE, _voltages),
    (FIXED_STEPS, _fixed_steps),
)
"""Every source with what computes its results."""
