"""Scenarios that must be refused, and every mistake that must be named in them: its line, key and words.

Most are the scenario `GOOD` with one line changed. Its lines are counted from 1; `PATHS` has their keys.
"""

from __future__ import annotations

from msgspec import Struct

GOOD = """\
schema_version: 1
title: Good
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 0.0041
  restitution: 0.5
  length_m: 0.7
  membrane:
    bias_voltage_v: 2000
excitation:
  amplitude_n: 3.0
  frequency_hz: 2.0
inclination_deg: 45
gravity_m_s2: 9.8
period_ratio: 1
sweep:
  parameter: length_m
  from: 0.59
  to: 0.75
"""
MINIMAL = """\
schema_version: 1
device: {capsule_mass_kg: 0.1, restitution: 0.5, length_m: 1}
excitation: {amplitude_n: 3, frequency_hz: 2}
inclination_deg: 0
"""
_ROWS = GOOD.splitlines()
_DEVICE = [f"device.{key}" for key in ("capsule_mass_kg", "ball_mass_kg", "restitution", "length_m", "membrane")]
PATHS = [
    *("schema_version", "title", "device", *_DEVICE, "device.membrane.bias_voltage_v", "excitation"),
    *("excitation.amplitude_n", "excitation.frequency_hz", "inclination_deg", "gravity_m_s2", "period_ratio"),
    *("sweep", "sweep.parameter", "sweep.from", "sweep.to"),
]
DEVICE, LENGTH, AMPLITUDE, ANGLE = "device", "device.length_m", "excitation.amplitude_n", "inclination_deg"
BALL, MEMBRANE = "device.ball_mass_kg", "device.membrane"
MISSING = "required, but missing"
UNSWEPT = "required unless it is swept, but missing"


class Bad(Struct, frozen=True):
    """A text that is no scenario, and all that must be said: (line, path, fragment of the message)."""

    text: str | bytes
    expected: tuple[tuple[int, str, str], ...]

    @property
    def name(self) -> str:
        """The first mistake."""
        return ": ".join(filter(None, self.expected[0][1:]))


def bad(text: str | bytes, *expected: tuple[int, str, str]) -> Bad:
    return Bad(text, expected)


def good_but(number: int, row: str) -> str:
    """Return GOOD with one line put in another's place."""
    return "".join(f"{row if i == number else old}\n" for i, old in enumerate(_ROWS, 1))


def without(*numbers: int) -> str:
    """Return GOOD without some of its lines."""
    return "".join(f"{row}\n" for i, row in enumerate(_ROWS, 1) if i not in numbers)


def value(number: int, value: str, fragment: str) -> Bad:
    """Build the case of a line's key with another value."""
    key, path = _ROWS[number - 1].partition(":")[0], PATHS[number - 1]
    return bad(good_but(number, f"{key}: {value}"), (number, path, fragment))


def key(number: int, path: str, row: str, fragment: str, *also: tuple[int, str, str]) -> Bad:
    """Build the case of a line with an unknown key, which alone is told of it; `also` is what a rule says."""
    wanted = sorted([(number, path, fragment), *also], key=lambda expected: expected[0])
    return bad(good_but(number, row), *wanted)


def row(number: int, row: str, path: str, fragment: str) -> Bad:
    """Build the case of another line in the place of one of GOOD."""
    return bad(good_but(number, row), (number, path, fragment))


NOT_A_NUMBER = (
    value(7, '"0.7"', 'got "0.7", which is text; write 0.7, without quotes (a number from 1e-15 to 1e15, in m)'),
    value(7, "'1e-3'", "write 1e-3, without quotes"),
    value(7, "0,7", "got '0,7', which is text; write 0.7, with a decimal point"),
    value(7, "0.7 m", "the unit stands in the key, write 0.7 (a number from"),
    value(7, "0.7m", "the unit stands in the key, write 0.7"),
    value(7, "700 mm", "the unit stands in the key, write 0.7"),
    value(7, "0,7 m", "the unit stands in the key, write 0.7"),
    value(7, "0.7 furlong", "the unit stands in the key ("),
    value(7, "1_000", "write 1000, without separators"),
    value(7, "1 000", "write 1000, without separators"),
    value(7, "1,000.5", "write 1000.5, without separators"),
    value(7, "7/10", "expressions are not evaluated"),
    value(7, "yes", "got 'yes', which is text (a number from 1e-15 to 1e15, in m)"),
    value(7, "off", "got 'off', which is text"),
    value(7, "true", "got true, which is not a number"),
    value(7, "1:30", "got '1:30', which is text"),
    value(7, "2024-01-01", "got '2024-01-01', which is text"),
    value(7, "\u22120.7", "write -0.7, with the '-' of the keyboard"),
    value(7, "\uff11.\uff15", "which is text"),
    value(7, "NaN", "got 'NaN', which is text"),
    value(7, "0b11", "got '0b11', which is text"),
    value(7, "[0.7]", "got a list, where one value belongs"),
    value(7, "{m: 0.7}", "got a block of keys, where one value belongs"),
    value(7, "|\n    0.7", "which is text"),
    value(13, "-45°", "got '-45°', which is text; the unit stands in the key, write -45"),
    value(13, "0.785 rad", "write 44.97"),
    value(13, "pi/4", "expressions are not evaluated"),
)

OUT_OF_RANGE = (
    value(7, ".nan", "got .nan, which is not a finite number (a number from 1e-15 to 1e15, in m)"),
    value(7, "-.inf", "got -.inf, which is not a finite number"),
    value(7, "1e400", "got 1e400, which is not a finite number"),
    value(7, "9" * 5000, "..., which is not a finite number"),
    value(7, "0x" + "f" * 5000, "..., which is not a finite number"),
    value(7, "-0.7", "got -0.7, which is not positive (a number from 1e-15 to 1e15, in m)"),
    value(7, "0", "got 0, which is not positive"),
    value(7, "1e-20", "got 1e-20, which is too small"),
    value(7, "1e20", "got 1e20, which is too large"),
    value(6, "1.5", "got 1.5, which is too large (a number from 0 to 1)"),
    value(6, "-0.1", "got -0.1, which is too small (a number from 0 to 1)"),
    value(13, "91", "got 91, which is too large (a number from 0 to 90, in deg)"),
    value(14, "0.0", "which is not positive (a number from 1e-15 to 1e15, in m/s^2)"),
    value(15, "0", "got 0, which is not positive (a whole number from 1 to 20)"),
    value(15, "21", "got 21, which is too large"),
    value(15, "1.5", "got 1.5, which is not a whole number"),
    value(15, "2.0", "got 2.0; write 2"),
    value(1, "2", "got 2, a version that is not known to this program (always 1)"),
    value(1, '"1"', "without quotes (always 1)"),
    value(1, "1.0", "got 1.0; write 1"),
    value(1, "true", "got true, which is not a number"),
    value(2, "3", "got 3, which is not text; put it in quotes (printable text on one line, 1 to 200 characters)"),
    value(2, "''", "which is empty"),
    value(2, "'  '", "which is empty (printable text on one line"),
    value(2, '"\\e[31m"', r'got "\x1b[31m", which has characters that cannot be printed (printable text on one line'),
    value(2, '"two\\nlines"', r'got "two\nlines", which has characters that cannot be printed'),
    value(2, "x" * 201, "has 201 characters"),
    value(2, '"\\ud83d"', "half a character"),
)

RELATIONS = (
    row(
        9,
        "    ball_radius_m: 7e-3",
        f"{MEMBRANE}.ball_radius_m",
        "got 0.007, which is too large (below active_radius_m",
    ),
    row(9, "    active_radius_m: 5e-3", f"{MEMBRANE}.active_radius_m", "(above ball_radius_m, 0.005 by default)"),
    row(
        9,
        "    thickness_m: 1e-3",
        f"{MEMBRANE}.thickness_m",
        "relative_permittivity and breakdown_field_v_m not given (all of thickness_m,",
    ),
    bad(
        GOOD + "requirements: {power_at_least_mw: 1}\n",
        (20, "requirements.power_at_least_mw", "power, efficiency and field need device.membrane.thickness_m"),
    ),
    *(
        bad(f"{GOOD}design: {{maximise: {what}, vary: [{rows}]}}\n", (20, f"design.{path}", message))
        for what, rows, path, message in (
            ("u_ave_v", "", "vary", "a list of 1 to 4 blocks of keys"),
            ("u_ave_v", f"{{path: {ANGLE}, from: 10, to: 91}}", "vary.0.to", "from 0 to 90, in deg"),
            ("u_ave_v", f"{{path: {LENGTH}, from: 1, to: 1}}", "vary.0.to", "the same as from"),
            (
                "u_ave_v",
                f"{{path: {LENGTH}, from: 1, to: 2}}, {{path: {LENGTH}, from: 1, to: 2}}",
                "vary.1.path",
                "is varied already",
            ),
            ("u_ave_v", f"{{path: {BALL}, from: 1e-3, to: 0.2}}", "vary.0.to", "below capsule_mass_kg"),
            (
                "u_ave_v",
                "{path: device.capsule_mass_kg, from: 4e-3, to: 0.2}",
                "vary.0.from",
                "got 0.004, which is too small (above ball_mass_kg, 0.0041)",
            ),
            (
                "u_ave_v",
                f"{{path: {MEMBRANE}.ball_radius_m, from: 4e-3, to: 7e-3}}",
                "vary.0.to",
                "got 0.007, which is too large (below active_radius_m, 0.0063)",
            ),
            (
                "u_ave_v",
                f"{{path: {MEMBRANE}.thickness_m, from: 1e-3, to: 2e-3}}",
                "vary.0.path",
                f"{MEMBRANE}.thickness_m is not given",
            ),
            ("power_mw", f"{{path: {LENGTH}, from: 1, to: 2}}", "maximise", "needs device.membrane.thick"),
            ("colour", f"{{path: {LENGTH}, from: 1, to: 2}}", "maximise", "one of u_ave_v, voltage_rate"),
        )
    ),
    bad(
        without(5, 8, 9) + f"design: {{maximise: wall_gap, vary: [{{path: {MEMBRANE}.exponent, from: 2, to: 3}}]}}\n",
        (17, "design.vary.0.path", "membranes are evaluated where device.ball_mass_kg is given (give it)"),
    ),
    bad(without(5), (7, MEMBRANE, "ball_mass_kg is required where energy is evaluated")),
    value(17, "lenght_m", "got 'lenght_m'; did you mean 'length_m'? (one of length_m, amplitude_n, frequency_hz,"),
    value(17, "device.length_m", "did you mean 'length_m'?"),
    value(17, "capsule_mass_kg", "got 'capsule_mass_kg', which cannot be swept"),
    value(17, "[length_m]", "got a list, where one value belongs"),
    value(17, "3", "got 3 (one of length_m"),
    value(18, "0", "got 0, which is not positive (a number from 1e-15 to 1e15, in m)"),
    value(19, ".inf", "got .inf, which is not a finite number (a number from 1e-15 to 1e15, in m)"),
    value(19, "0.59", "got 0.59, the same as sweep.from to nine digits (a different value)"),
    bad(
        without(16, 17, 18, 19) + "sweep: {parameter: inclination_deg, from: -5, to: 95}\n",
        (16, "sweep.from", "got -5, which is too small (a number from 0 to 90, in deg)"),
        (16, "sweep.to", "got 95, which is too large"),
    ),
)

LEFT_OUT = (
    bad(without(1), (1, "schema_version", f"{MISSING} (always 1)")),
    bad(without(4), (3, "device.capsule_mass_kg", f"{MISSING} (a number from")),
    bad(without(7, 16, 17, 18, 19), (3, LENGTH, UNSWEPT)),
    bad(without(11), (10, AMPLITUDE, f"{UNSWEPT} (a number from 1e-15 to 1e15, in N)")),
    bad(
        MINIMAL.replace("restitution: 0.5", "restitution: 0.5, capsule: free"),
        (2, "device.capsule", "a free capsule recoils from the ball, whose mass is not given (give ball_mass_kg"),
    ),
    bad(
        MINIMAL.replace("restitution: 0.5", "restitution: 0.5, capsule: heavy"),
        (2, "device.capsule", "got 'heavy' (one of prescribed, free)"),
    ),
    bad(without(13), (1, ANGLE, f"{UNSWEPT} (a number from 0 to 90, in deg)")),
    bad(without(10, 11, 12), (1, "excitation", "(a block of keys: amplitude_n, frequency_hz, harmonics, record)")),
    bad(without(17), (16, "sweep.parameter", f"{MISSING} (one of length_m")),
    value(4, "", "is empty (a number"),
    value(11, "null", "required unless it is swept, but empty"),
    value(14, "~", "is empty (a number"),
    bad(without(4, 5, 6, 7, 8, 9), (3, DEVICE, "is empty (a block of keys: capsule_mass_kg")),
    bad(without(*range(3, 10)) + "device: 5\n", (13, DEVICE, "got 5 (a block of keys")),
    bad(without(*range(3, 10)) + "device: [1]\n", (13, DEVICE, "got a list (a block")),
    bad(without(16, 17, 18, 19) + "sweep: length_m\n", (16, "sweep", "got 'length_m' (a")),
)

UNKNOWN = (
    key(7, "device.lenght_m", "  lenght_m: 0.7", "unknown key; did you mean 'length_m'? (allowed in device: "),
    key(7, "device.length_mm", "  length_mm: 700", "'length_m'? It is in m: 1 mm is 0.001 m, so length_m: 0.7"),
    key(7, "device.length_mm", "  length_mm: long", "It is in m: 1 mm is 0.001 m (allowed"),
    key(7, "device.length", "  length: 0.7", "did you mean 'length_m'? (allowed"),
    key(7, "device.Length_M", "  Length_M: 0.7", "did you mean 'length_m'? (allowed"),
    key(7, "device.'length-m'", "  length-m: 0.7", "did you mean 'length_m'? (allowed"),
    key(7, "device.s", "  s: 0.7", "did you mean 'length_m'? (allowed"),
    key(7, "device.gap_mm", "  gap_mm: 700", "so length_m: 0.7"),
    key(7, "device.l\u0435ngth_m", "  l\u0435ngth_m: 0.7", "it contains '\u0435' (CYRILLIC SMALL LETTER IE); did"),
    key(7, "device.frequency_hz", "  frequency_hz: 2", "did you mean 'excitation.frequency_hz'?"),
    key(7, "device.on", "  on: 1", "unknown key (allowed in device: capsule_mass_kg,"),
    key(14, "gravity", "gravity: 9.81", "did you mean 'gravity_m_s2'? (allowed: schema_version, title, device,"),
    key(
        14,
        "simulation.periods",
        "simulation: {periods: 100}",
        "unknown key; did you mean 'motions.periods'? (allowed in simulation: ",
    ),
    key(14, "simulation.samples", "simulation: {samples: 1}", "got 1, which is too small (a whole number from 2 to"),
    key(14, "simulation.samples", "simulation: {samples: 4.0}", "got 4.0; write 4"),
    key(14, "simulation.samples", "simulation: {samples: true}", "which is not a number"),
    key(14, "simulation.starts", "simulation: {starts: 65}", "got 65, which is too large (a whole number from 1 to 64"),
    key(14, "simulation.tolerance", "simulation: {tolerance: 0}", "got 0, which is too small (a number above 0"),
    key(14, "simulation.diagram", "simulation: {diagram: yes}", "which is not true or false (true or false)"),
    key(14, "simulation.diagram", "simulation: {diagram: 1}", "which is not true or false"),
    key(14, "simulation.portraits", "simulation: {portraits: 0.6}", "where a list belongs (a list of at most 8 num"),
    key(14, "simulation.portraits", "simulation: {portraits: }", "is empty (a list of at most 8 numbers"),
    key(14, "simulation.portraits.1", "simulation: {portraits: [0.6, a]}", "got 'a', which is text (a number from"),
    key(14, "simulation.portraits.1", "simulation: {portraits: [0.6, null]}", "is empty (a number from 1e-15"),
    key(14, "simulation.portraits.0", "simulation: {portraits: [[1]]}", "got a list, where one value belongs (a num"),
    key(14, "simulation.portraits.0", "simulation: {portraits: [true]}", "got true, which is not a number"),
    key(14, "simulation.portraits.0", "simulation: {portraits: [.nan]}", "got .nan, which is not a finite number"),
    key(14, "simulation.portraits.0", "simulation: {portraits: [-0.6]}", "got -0.6, which is not positive"),
    key(14, "simulation.portraits.0", "simulation: {portraits: [*a]}", "aliases are not read"),
    key(14, "motions.portraits.1", "motions: {portraits: [BBT, v3]}", "got 'v3' (a word such as BBT, or a label such"),
    key(14, "motions.starts.0.word", "motions: {starts: [{word: BXT, value: 0.6}]}", "got 'BXT'"),
    key(14, "motions.starts.0.value", "motions: {starts: [{word: BBT}]}", "required, but missing"),
    key(14, "motions.starts.0.value", "motions: {starts: [{word: BBT, value: 9}]}", "got 9, outside the sweep (from"),
    key(14, "motions.starts.0.word", "motions: {impacts: 2, starts: [{word: BBT, value: 0.6}]}", "has 3 impacts, and"),
    key(14, "motions.starts.0.periods", "motions: {starts: [{word: B, value: 0.6, periods: 5}]}", "periods is 4"),
    key(14, "motions.portraits", "motions: {portraits: BBT}", "where a list belongs (a list of at most 8 names: a wo"),
    key(14, "motions.portraits.0", "motions: {portraits: [3]}", "got 3, which is not text; put it in quotes"),
    key(14, "simulation.start", "simulation: {start: 4}", "did you mean 'starts'?"),
    key(14, "simulation.tol", "simulation: {tol: 1e-9}", "did you mean 'tolerance'?"),
    bad(
        GOOD + "simulation:\n  displacement:\n    - 0.6\n    - '0.7'\n    - 0,6\n    - 700 mm\n    - -1\n",
        (23, "simulation.displacement.1", "write 0.7, without quotes (a number from 1e-15 to 1e15, in m)"),
        (24, "simulation.displacement.2", "write 0.6, with a decimal point"),
        (25, "simulation.displacement.3", "the unit stands in the key, write 0.7"),
        (26, "simulation.displacement.4", "got -1, which is not positive"),
    ),
    bad(
        without(16, 17, 18, 19)
        + "sweep: {parameter: inclination_deg, from: 5, to: 95}\nsimulation: {portraits: [95, 90]}\n",
        (16, "sweep.to", "got 95, which is too large"),
        (17, "simulation.portraits.0", "got 95, which is too large (a number from 0 to 90, in deg)"),
    ),
    bad(
        without(16, 17, 18, 19) + "simulation: {diagram: true, follow: up, portraits: [-1]}\n",
        (16, "simulation.diagram", "a bifurcation diagram needs a sweep"),
        (16, "simulation.follow", "there is no sweep to go through"),
        (16, "simulation.portraits.0", "got -1, which is not positive (a number from 1e-15 to 1e15, in m)"),
    ),
    bad(without(16, 17, 18, 19) + "sweep: *a\nsimulation: {diagram: true}\n", (16, "sweep", "aliases are not read")),
    key(14, "simulation.displacement", "simulation: {displacement: [1,1,1,1,1,1,1,1,1]}", "a list of 9 values"),
    key(14, "simulation", "simulation: [1]", "(a block of keys: samples, starts,"),
    key(14, "'device.length_m'", "device.length_m: 1", "unknown key with a dot in it"),
    key(14, "''", "'': 1", "unknown key (allowed"),
    key(14, r"'a\nb'", r'"a\nb": 1', "unknown key (allowed"),
    key(14, f"'{'x' * 60}'", f"{'x' * 90}: 1", "unknown key (allowed"),
    key(5, "device.ball_mass_g", "  ball_mass_g: 4.1", "so ball_mass_kg: 0.0041", (8, MEMBRANE, "ball_mass_kg is")),
    key(6, "device.r", "  r: 0.5", "did you mean 'restitution'?"),
    key(13, "inclination", "inclination: 45", "did you mean 'inclination_deg'? (allowed"),
    key(13, "inclination_rad", "inclination_rad: 0.785", "1 rad is 57.2958 deg, so inc"),
    key(13, "beta", "beta: 45", "did you mean 'inclination_deg'? (allowed"),
    key(11, "excitation.amplitude_kn", "  amplitude_kn: 0.003", "1 kN is 1000 N, so"),
    key(
        12,
        "excitation.frequency_rad_s",
        "  frequency_rad_s: 12.566",
        "1 rad/s is 0.159155 Hz, so frequency_hz: 1.99994",
    ),
    key(12, "excitation.omega", "  omega: 12.566", "did you mean 'frequency_hz'? It is in Hz: 1 rad/s is"),
    key(18, "sweep.start", "  start: 0.59", "did you mean 'from'?"),
    bad(GOOD + "  step: 0.1\n", (20, "sweep.step", "unknown key (allowed in sweep: parameter, from, to)")),
)

REQUIRED = "requirements"


def required(keys: str, key: str, fragment: str, text: str = GOOD) -> Bad:
    """Build the case of a requirement below a scenario."""
    line, path = text.count("\n") + 1, f"{REQUIRED}.{key}" if key else REQUIRED
    return bad(f"{text}{REQUIRED}: {{{keys}}}\n", (line, path, fragment))


NO_SWEEP, NO_LENGTH = without(16, 17, 18, 19), without(7)
TILTED = without(13, 16, 17, 18, 19) + "inclination_deg: 0\nsweep: {parameter: inclination_deg, from: 0, to: 60}\n"
REQUIREMENTS = (
    required("", "", "nothing is required in it (give one of its keys, or delete it)"),
    required("u_ave_at_least_v: null", "", "nothing is required in it"),
    bad(GOOD + "requirements:\n", (20, REQUIRED, "nothing is required in it")),
    bad(GOOD + "requirements: 5\n", (20, REQUIRED, "got 5 (a block of keys: stable_from,")),
    required("u_ave: 5", "u_ave", "unknown key (allowed in requirements: stable_from,"),
    required("margin_grazing: 5", "margin_grazing", "did you mean 'margin_grazing_percent'? (allowed in requirements"),
    required("u_ave_at_least_kv: 5", "u_ave_at_least_kv", "1 kV is 1000 V, so u_ave_at_least_v: 5000"),
    required("margin_any_percent: 0", "margin_any_percent", "(a number above 0, at most 75, in %)"),
    required("margin_any_percent: 75.1", "margin_any_percent", "got 75.1, which is too large"),
    required("margin_any_percent: 5 %", "margin_any_percent", "the unit stands in the key, write 5"),
    required("deflection_at_most_m: -1", "deflection_at_most_m", "which is not positive (a number from 1e-15"),
    required("inclination_from_deg: 20", "inclination_from_deg", "inclination_to_deg is not given (both ends"),
    required("inclination_from_deg: 20, inclination_to_deg: 91", "inclination_to_deg", "got 91, which is too large"),
    required("inclination_from_deg: 20, inclination_to_deg: 20.0", "inclination_to_deg", "which makes no range"),
    required("stable_to: 0.7", "stable_to", "stable_from is not given (both ends of a range, or neither)"),
    required(
        "stable_from: 0.6, stable_to: 0.76", "stable_to", "got 0.76, which is outside the sweep (a number from 0.59"
    ),
    required("stable_from: a, stable_to: 0.7", "stable_from", "which is text (a number from 1e-15 to 1e15, in m)"),
    required(
        "crosscheck_passed: true", "crosscheck_passed", "a cross-check needs simulation, which is not given (give"
    ),
    required("crosscheck_passed: yes", "crosscheck_passed", "which is not true or false (true or false)"),
    required(
        "crosscheck_passed: false",
        "crosscheck_passed",
        "got false, which requires nothing (true",
        GOOD + "simulation: {}\n",
    ),
    required(
        "u_ave_difference_at_most_v: 5",
        "u_ave_difference_at_most_v",
        "a range of the swept parameter, or a motion that is followed along it, needs sweep",
        NO_SWEEP,
    ),
    required("word: BX", "word", "got 'BX', which is no word of at most 16 letters B and T (1 to 16 impacts in order"),
    required("word: [BT]", "word", "got a list, where one value belongs"),
    required("word: 5", "word", "which is not text"),
    required("words: BT", "words", "got 'BT', where a list belongs (a list of 1 to 8 words)"),
    required("words: [BT, b]", "words.1", "got 'b', which is no word"),
    required("words: []", "words", "got a list of 0 values (a list of 1 to 8 words)"),
    required("word: BT", "word", "a motion that is followed along it, needs sweep", NO_SWEEP),
    required("words: [BT]", "words", "is judged is not given (give device.length_m,", NO_LENGTH),
    required(
        "deflection_at_most_m: 5",
        "deflection_at_most_m",
        "need device.ball_mass_kg, which is not given",
        without(5, 8, 9),
    ),
    required("margin_any_percent: 5", "margin_any_percent", "is judged is not given (give device.length_m,", NO_LENGTH),
    required("u_ave_at_least_v: 5", "u_ave_at_least_v", "is judged is not given (give device.length_m,", NO_LENGTH),
    bad(
        NO_LENGTH + "requirements:\n  inclination_from_deg: 5\n  inclination_to_deg: 6\n",
        (20, f"{REQUIRED}.inclination_from_deg", "(give device.length_m, or leave this out)"),
        (21, f"{REQUIRED}.inclination_to_deg", "(give device.length_m, or leave this out)"),
    ),
)


def off(keys: str, key: str, fragment: str, text: str = GOOD) -> Bad:
    """Build the case of a tolerance below a scenario."""
    line, path = text.count("\n") + 1, f"tolerances.{key}" if key else "tolerances"
    return bad(f"{text}tolerances: {{{keys}}}\n", (line, path, fragment))


_EITHER = "(either restitution, of both membranes, or restitution_bottom and restitution_top)"
RESTITUTIONS = (
    bad(
        good_but(6, "  restitution: 0.5\n  restitution_bottom: 0.4"),
        (7, "device.restitution_bottom", f"restitution is given as well {_EITHER}"),
    ),
    bad(
        good_but(6, "  restitution_top: 0.4"),
        (6, "device.restitution_top", f"restitution_bottom is not given {_EITHER}"),
    ),
    bad(
        good_but(6, "  restitution_bottom: 0.4\n  restitution_top: 0.4000000001"),
        (
            7,
            "device.restitution_top",
            "which is 0.4 at the bottom but for rounding (equal ones, or 1e-09 apart at least)",
        ),
    ),
    bad(good_but(6, "  restitution_bottom: 1.2\n  restitution_top: 0.4"), (6, "device.restitution_bottom", "got 1.2")),
)
TOLERANCES = (
    off("samples: 64", "", "it has no tolerance (give one, such as length_percent, or delete it)"),
    off("length_m: null", "", "it has no tolerance"),
    bad(GOOD + "tolerances:\n", (20, "tolerances", "it has no tolerance")),
    off("length_percent: 51", "length_percent", "got 51, which is too large (a number above 0, at most 50, in %)"),
    off("length_m: 0.7, amplitude_percent: 3", "length_m", "takes length_m 0.7 off 0.7 (at most 0.7)"),
    off("length_mm: 1", "length_mm", "did you mean 'length_m'? It is in m: 1 mm is 0.001 m"),
    off("restitution: 0.5", "restitution", "takes restitution 0.5 off 0.5 (at most 0.499999)"),
    off("capsule_mass_percent: 1, samples: 100", "samples", "no power of 2; Sobol's points need one (such as 128)"),
    off("restitution: 0.1, distribution: flat", "distribution", "got 'flat' (one of uniform, normal)"),
    off(
        "inclination_percent: 1",
        "inclination_percent",
        "a percentage of inclination_deg: 0 is nothing (give inclination_deg here)",
        without(13) + "inclination_deg: 0\n",
    ),
    required("survives_shock_m_s: 0.3", "survives_shock_m_s", "a shock needs disturbances, which is not given"),
    required(
        "phase_jitter_at_most_deg: 5",
        "phase_jitter_at_most_deg",
        "needs disturbances.jitter_m_s or disturbances.jitter_restitution",
    ),
    bad(GOOD + "disturbances:\n  jitter_m_s: 0\n", (21, "disturbances.jitter_m_s", "got 0, which is not positive")),
    bad(GOOD + "disturbances:\n  jitter_m_s: 10 mm/s\n", (21, "disturbances.jitter_m_s", "got '10 mm/s'")),
    bad(GOOD + "disturbances:\n  jitter_restitution: 2\n", (21, "disturbances.jitter_restitution", "got 2")),
    required("yield_at_least_percent: 99", "yield_at_least_percent", "a yield needs tolerances, which is not given"),
)

MEASURED = (
    bad(GOOD + "measured: []\n", (20, "measured", "got a list of 0 values")),
    bad(
        GOOD
        + "measured:\n- {impacts: a.csv, value: 0.9, direction: left}\n- {value: 0.7}\n"
        + "- {impacts: b.csv, force_maximum_error_s: 1e-4}\n",
        (21, "measured.0.direction", "got 'left'"),
        (21, "measured.0.value", "got 0.9, outside the sweep (from 0.59 to 0.75)"),
        (22, "measured.1.impacts", "required, but missing"),
        (23, "measured.2.force_maximum_error_s", "the time itself is not given"),
    ),
    bad(
        MINIMAL + "measured: [{impacts: a.csv, value: 1, direction: up}]\n",
        (5, "measured.0.value", "there is no sweep to which it could belong"),
        (5, "measured.0.direction", "there is no sweep to which it could belong"),
    ),
)

EFFECTS = (
    bad(GOOD + "effects: []\n", (20, "effects", "")),
    bad(
        GOOD
        + "effects:\n- effect: restitution_bottom\n- {effect: capsule, percent: 3}\n"
        + "- {effect: second_harmonic, percent: -2}\n- {effect: restitution_top, percent: 0}\n"
        + "- {effect: membrane_stiffness}\n- {effect: restitution_bottom, percent: 60}\n- {effect: tea}\n",
        (21, "effects.0", "restitution_bottom needs a size"),
        (22, "effects.1.percent", "capsule has no size"),
        (23, "effects.2.percent", "got -2, of a harmonic at its worst phase (above 0)"),
        (24, "effects.3.percent", "restitution_top needs a size"),
        (25, "effects.4.effect", "membrane_stiffness is always considered where it matters"),
        (26, "effects.5.percent", "got 60"),
        (27, "effects.6.effect", "got 'tea'"),
    ),
    bad(
        GOOD
        + "effects:\n- effect: restitution_exponent\n- {effect: restitution_exponent, percent: 3, exponent: -0.1}\n"
        + "- {effect: restitution_exponent, exponent: 0.1}\n"
        + "- {effect: restitution_bottom, percent: 3, exponent: -0.1}\n"
        + "- {effect: restitution_bottom, percent: 3, speed_m_s: 5}\n"
        + "- {effect: restitution_exponent, exponent: -0.1, speed_m_s: 0}\n",
        (21, "effects.0", "restitution_exponent needs an exponent"),
        (22, "effects.1.percent", "restitution_exponent has no per cent, but an exponent"),
        (23, "effects.2.exponent", "got 0.1"),
        (24, "effects.3.exponent", "restitution_bottom has no exponent"),
        (25, "effects.4.speed_m_s", "restitution_bottom has no speed"),
        (26, "effects.5.speed_m_s", "got 0"),
    ),
    bad(
        MINIMAL.replace("0.5", "0.8")
        + "effects:\n- {effect: capsule}\n- {effect: restitution_top, percent: 30}\n"
        + "- {effect: restitution_top, percent: 24}\n",
        (6, "effects.0.effect", "needs device.ball_mass_kg"),
        (7, "effects.1.percent", "makes restitution_top 1.04 (below 1)"),
    ),
    bad(
        MINIMAL.replace("0.5", "0") + "effects:\n- {effect: restitution_bottom, percent: -5}\n",
        (6, "effects.0.percent", "a percentage of restitution_bottom: 0 is nothing"),
    ),
    bad(
        without(7) + "effects:\n- {effect: capsule}\n",
        (19, "effects", "the design point is not given (give device.length_m, or delete them)"),
    ),
)

STRUCTURE = (
    bad(GOOD + "title: Again\n", (20, "title", "given twice, first on line 2")),
    bad(good_but(8, "  length_m: 0.8\n  membrane:"), (8, LENGTH, "given twice, first on line 7")),
    row(10, "device:\n  length_m: 1\nexcitation:", DEVICE, "given twice, first on line 3"),
    row(14, "1: 2", "'1'", "the key 1 is not a name"),
    row(14, "~: 2", "'~'", "the key ~ is not a name"),
    row(14, "true: 2", "true", "the key true is not a name"),
    row(14, "? [a, b]\n: 2", "", "a key that is not a name"),
    row(14, r'"\ud83d": 2', r"'\ud83d'", "half a character"),
    row(11, "  amplitude_n: *f", AMPLITUDE, "aliases are not read, got *f (write the value out)"),
    row(11, "  amplitude_n: &f 3.0", AMPLITUDE, "anchors are not read, got &f (delete it)"),
    row(11, "  &f amplitude_n: 3.0", AMPLITUDE, "anchors and tags are not read"),
    row(14, "<<: {gravity_m_s2: 9.8}", "'<<'", "merge keys are not read"),
    row(14, "<<: *defaults", "'<<'", "merge keys are not read"),
    row(11, "  amplitude_n: !!float 3", AMPLITUDE, "tags are not read, got '!!float'"),
    row(2, "title: !!python/object/apply:os.system [ls]", "title", "tags are not read, got '!!python/object/apply:os."),
    row(16, "sweep: !sweep", "sweep", "tags are not read, got '!sweep'"),
    bad(GOOD + "---\n" + GOOD, (20, "", "a second document starts here")),
    bad("%YAML 1.1\n---\n" + GOOD, (1, "", "directives are not read")),
    bad("", (1, "", "the file is empty (a scenario starts with 'schema_version: 1'")),
    bad("# nothing\n\n# here\n", (1, "", "the file is empty")),
    bad("0.7\n", (1, "", "the file is not a block of keys")),
    bad("- schema_version: 1\n", (1, "", "the file is not a block of keys")),
    bad("[" * 100_000, (1, "0.0.0", "nested more than 20 levels deep")),
    bad("{" * 100_000, (1, "", "nested more than 20 levels deep")),
    bad("- " * 100_000, (1, "0.0.0", "nested more than 20 levels deep")),
    bad("? " * 100_000, (1, "", "nested more than 20 levels deep")),
    row(7, "  length_m: " + "[" * 100_000, f"{LENGTH}.0", "nested more than 20 levels deep"),
    bad(GOOD + f"list: [{'1, ' * 6000}]\n", (20, "list.4959", "more than 5000 keys and values")),
    bad(
        GOOD + "a: &a [x]\nb: [*a, *a]\n",
        (20, "a", "anchors are not read, got &a"),
        (20, "a", "unknown key"),
        (21, "b.0", "aliases are not read, got *a"),
        (21, "b.1", "aliases are not read, got *a"),
        (21, "b", "unknown key"),
    ),
)

SYNTAX = (
    row(7, "\tlength_m: 0.7", "", "a tab where YAML does not allow one"),
    row(7, "  length_m:\t0.7", "", "a tab where YAML does not allow one"),
    row(2, "title: 'Good", "", "a quote is opened here and never closed"),
    row(2, 'title: "Good', "", "a quote is opened here and never closed"),
    row(7, "  length_m: [0.7", "", "a '[' is opened here and not closed"),
    row(16, "sweep: {parameter: length_m", "", "a '{' is opened here and not closed"),
    row(7, "  length_m: ]", "", "a value is missing before this bracket"),
    row(2, "title: Harvester: sweep", "", "a second colon in one value"),
    row(7, "  length_m:0.7", "", "no space after the colon (write 'key: value')"),
    row(7, "  length_m 0.7", "", "a key without its colon (write 'key: value')"),
    row(7, " length_m: 0.7", "", "wrong indentation"),
    row(7, "    length_m: 0.7", "", "wrong indentation"),
    row(14, "- 9.8", "", "a list entry among keys"),
    row(2, "title: @home", "", "cannot start with this character"),
    row(2, "title: *", "", "a value cannot start with '*'"),
    row(2, 'title: "\\q"', "", "an unknown escape after '\\'"),
    row(2, 'title: "\\UFFFFFFFF"', "", "an escape or a number that does not exist"),
    row(2, "title: a\x07b", "", "the invisible character U+0007 is not allowed"),
    row(2, "title: a\u2028b", "", "the invisible character U+2028 is not allowed"),
    row(
        2,
        "title: a\u202eb",
        "title",
        r"got 'a\u202eb', which has characters that cannot be printed (printable text on one line",
    ),
    row(
        2,
        f"title: {'w' * 10_000}",
        "title",
        "which has 10000 characters (printable text on one line, 1 to 200 characters)",
    ),
    row(14, "gravity_m_s2: 9.8\x85", "", "the invisible character U+0085 is not allowed"),
    row(14, "\ufeffgravity_m_s2: 9.8", "", "the invisible character U+FEFF is not allowed"),
    bad(bytes(range(256)), (1, "", "the file is not text (save it as UTF-8 text)")),
    bad(good_but(2, "title: Caf\xe9").encode("latin-1"), (2, "", "the byte 0xE9, which is not UTF-8")),
    bad(GOOD.encode("utf-16"), (1, "", "the file is UTF-16 (save it as UTF-8 text)")),
    bad(GOOD + "#" * 2_000_000, (1, "", "the file is larger than 1 MB")),
    bad((GOOD + "#" * 2_000_000).encode(), (1, "", "the file is larger than 1 MB")),
)

SEVERAL = (
    bad(
        """\
schema_version: 2
device:
  capsule_mass_kg: 124,5
  lenght_m: 0.7
  restitution: 1.5
  membrane: {exponent: .nan}
excitation:
  amplitude_n: yes
  amplitude_n: 3
  frequency_hz: 2.0 Hz
inclination_deg: 45
inclination_deg: 30
""",
        (1, "schema_version", "got 2"),
        (3, "device.capsule_mass_kg", "with a decimal point"),
        (4, "device.lenght_m", "did you mean 'length_m'?"),
        (5, "device.restitution", "got 1.5"),
        (6, "device.membrane.exponent", "not a finite number"),
        (6, MEMBRANE, "ball_mass_kg is required"),
        (8, AMPLITUDE, "got 'yes'"),
        (9, AMPLITUDE, "given twice, first on line 8"),
        (10, "excitation.frequency_hz", "the unit stands in the key, write 2"),
        (12, ANGLE, "given twice, first on line 11"),
    ),
    bad(
        good_but(7, "  lenght_m: 0.7")
        + "requirements: {margin_any_percent: 5}\n"
        + "design: {minimise: length_m, vary: [{path: device.length_m, from: 0.6, to: 1}]}\n",
        (7, "device.lenght_m", "did you mean 'length_m'?"),
    ),
    bad(
        good_but(2, "title: &t Good").replace("9.8", "'9.8"),
        (2, "title", "anchors are not read"),
        (14, "", "a quote is opened here and never closed"),
    ),
    bad(
        good_but(3, "device: &d").replace("gravity_m_s2: 9.8", "<<: *d"),
        (3, DEVICE, "anchors are not read, got &d"),
        (14, "'<<'", "merge keys are not read"),
    ),
    bad(
        "schema_version: 1\ndevice: 1\nexcitation: []\ninclination_deg: {}\nsweep: true\n",
        (2, DEVICE, "got 1 (a block of keys"),
        (3, "excitation", "got a list (a block of keys"),
        (4, ANGLE, "got a block of keys, where one value belongs"),
        (5, "sweep", "got true (a block of keys"),
    ),
    bad(
        b"\xef\xbb\xbf" + good_but(7, "  length_m: -1").replace("\n", "\r\n").encode(),
        (7, LENGTH, "got -1, which is not positive"),
    ),
)

_HARMONIC = "excitation.harmonics.0"


def harmonics(rows: str, *expected: tuple[str, str]) -> Bad:
    """Build the case of harmonics in the place of the force's frequency, which go with it on one line."""
    row = f"  frequency_hz: 2.0\n  harmonics: [{rows}]"
    return bad(good_but(12, row), *((13, path, fragment) for path, fragment in expected))


HARMONICS = (
    harmonics(
        "{order: 2, percent: 1, phase_deg: 0}, {order: 2, percent: 2, phase_deg: 90}",
        ("excitation.harmonics.1.order", "order 2 is given already (each order once)"),
    ),
    harmonics(
        "{order: 2, percent: -1, phase_deg: 0}",
        (f"{_HARMONIC}.percent", "got -1, which is too small (a number from 0 to 50, in %)"),
    ),
    harmonics(
        "{order: 3, percent: 120, phase_deg: 0}",
        (f"{_HARMONIC}.percent", "got 120, which is too large (a number from 0 to 50, in %)"),
    ),
    harmonics(
        "{order: 3, percent: 1, phase_deg: quarter}",
        (f"{_HARMONIC}.phase_deg", "got 'quarter', which is text (a number from -360 to 360, in deg)"),
    ),
    harmonics(
        "{order: 1, percent: 1, phase_deg: 0}",
        (f"{_HARMONIC}.order", "got 1, which is too small (a whole number from 2 to 8)"),
    ),
    harmonics("{order: 2, percent: 1}", (f"{_HARMONIC}.phase_deg", "required, but missing")),
    harmonics("2, 5", (_HARMONIC, "got 2 (a block of keys"), (f"{_HARMONIC[:-1]}1", "got 5")),
    bad(
        good_but(12, "  frequency_hz: 2.0\n  harmonics: [{order: 2, percent: 1, phase_deg: 0}]")
        + "design: {maximise: margin_percent, vary: [{path: device.length_m, from: 0.3, to: 0.9}]}\naccuracy: {}\n"
        "disturbances: {prove: true}\n",
        (
            21,
            "design",
            "it is available for a sine force only, and excitation.harmonics is given (leave one of them out)",
        ),
        (22, "accuracy", "it is available for a sine force only"),
        (23, "disturbances.prove", "it is available for a sine force only"),
    ),
)


def friction(value: str, more: str, *expected: tuple[int, str, str]) -> Bad:
    """Build the case of friction behind the length, with more at the end of the file."""
    return bad(good_but(7, f"  length_m: 0.7\n  friction: {value}") + more, *expected)


_RUBS = "it is available without friction only, and device.friction is given (leave one of them out)"

FRICTION = (
    friction("-0.1", "", (8, "device.friction", "got -0.1, which is too small (a number from 0 to 2")),
    friction("little", "", (8, "device.friction", "got 'little', which is text")),
    friction(
        "0.1",
        "motions: {}\nrequirements: {word: BT, inclination_from_deg: 20, inclination_to_deg: 30}\n"
        "tolerances: {length_m: 0.01}\ndisturbances: {prove: true}\naccuracy: {}\n",
        (21, "motions", _RUBS),
        (22, "requirements.word", _RUBS),
        (22, "requirements.inclination_from_deg", _RUBS),
        (22, "requirements.inclination_to_deg", _RUBS),
        (23, "tolerances", _RUBS),
        (24, "disturbances.prove", _RUBS),
        (25, "accuracy", _RUBS),
    ),
    bad(
        good_but(7, "  length_m: 0.7\n  friction: 0.1")
        .replace("restitution: 0.5", "restitution: 0")
        .replace("parameter: length_m", "parameter: inclination_deg"),
        (6, "device.restitution", "got 0: a ball that does not bounce is computed without friction only"),
        (18, "sweep.parameter", "along a sweep of the inclination, with which friction changes"),
    ),
)


def falling(keys: str, more: str, *expected: tuple[int, str, str]) -> Bad:
    """Build the case of keys of the device behind the length, in one row, with more at the end of the file."""
    return bad(good_but(7, f"  length_m: 0.7\n  {keys}") + more, *expected)


_FALLS = "it is available for a constant restitution only, and device.restitution_exponent is given"
_LAW = "restitution_exponent: -0.1\n  restitution_speed_m_s: 2"
_EXPONENT, _STATED = "device.restitution_exponent", "device.restitution_speed_m_s"

FALLING = (
    falling("restitution_exponent: 0.1", "", (8, _EXPONENT, "got 0.1, which is too large")),
    falling("restitution_exponent: -0.6", "", (8, _EXPONENT, "got -0.6, which is")),
    falling("restitution_exponent: -0.1", "", (8, _EXPONENT, "the speed is"), (17, "sweep", _FALLS)),
    falling("restitution_speed_m_s: 2", "", (8, _STATED, "the restitution does not dep")),
    falling(
        "restitution_exponent: -0.1\n  restitution_speed_m_s: 0",
        "",
        (9, _STATED, "got 0, which is not positive (a number from 0.001 to 1000"),
        (18, "sweep", _FALLS),
    ),
    falling(
        f"{_LAW}\n  friction: 0.1",
        "motions: {}\nrequirements: {word: BT, inclination_from_deg: 20, inclination_to_deg: 30}\n"
        "effects: [{effect: restitution_exponent, exponent: -0.1}]\n",
        (10, "device.friction", "got 0.1, which cannot be combined with device.restitution_exponent"),
        (19, "sweep", _FALLS),
        (23, "motions", _RUBS),
        (24, "requirements.word", _RUBS),
        (24, "requirements.inclination_from_deg", _RUBS),
        (24, "requirements.inclination_to_deg", _RUBS),
        (25, "effects.0.effect", "the restitution falls with speed already, by"),
    ),
    falling(
        _LAW,
        "accuracy: {}\ndisturbances: {}\ntolerances: {length_m: 0.01}\n",
        (18, "sweep", _FALLS),
        (22, "accuracy", _FALLS),
        (23, "disturbances", _FALLS),
        (24, "tolerances", _FALLS),
    ),
    bad(
        good_but(7, f"  length_m: 0.7\n  {_LAW}").replace("restitution: 0.5", "restitution: 0"),
        (6, "device.restitution", "got 0, which cannot fall with speed"),
        (18, "sweep", _FALLS),
    ),
)


def along_restitution(end: str, more: str, *expected: tuple[int, str, str]) -> Bad:
    """Build the case of a sweep over the restitution of both membranes, with another key or block."""
    text = GOOD.replace("parameter: length_m", "parameter: restitution").replace("to: 0.75", f"to: {end}")
    return bad(f"{text}{more}", *expected)


_WORD = "requirements.word"
_ONLY = "along a sweep of a restitution only 1:1 motions are computed (leave this out, or sweep something else)"

ALONG_RESTITUTION = (
    along_restitution("1", "", (19, "sweep.to", "which is too large (a number from 0 to 0.999999")),
    along_restitution("0.75", "motions: {impacts: 3}\n", (20, "motions", _ONLY)),
    along_restitution("0.75", "requirements: {word: BBT}\n", (20, _WORD, _ONLY)),
    along_restitution("0.75", "accuracy: {}\n", (20, "accuracy", "it is available for constant membranes")),
    bad(
        GOOD.replace("parameter: length_m", "parameter: restitution").replace(
            "restitution: 0.5", "restitution_bottom: 0.2\n  restitution_top: 0.8"
        ),
        (20, "sweep.to", "a mean at which that of one membrane is out of range (from 0.3 to 0.699999)"),
    ),
    bad(
        GOOD.replace("parameter: length_m", "parameter: restitution")
        .replace("from: 0.59", "from: 0\n  # of a ball with friction")
        .replace("restitution: 0.5", "restitution: 0.5\n  friction: 0.1"),
        (19, "sweep.from", "got 0: a ball that does not bounce is computed without friction only"),
    ),
)


BAD_SCENARIOS = (
    *ALONG_RESTITUTION,
    *(*NOT_A_NUMBER, *OUT_OF_RANGE, *RELATIONS, *RESTITUTIONS, *LEFT_OUT, *UNKNOWN),
    *(*REQUIREMENTS, *TOLERANCES, *EFFECTS, *MEASURED, *HARMONICS, *FRICTION, *FALLING, *STRUCTURE, *SYNTAX, *SEVERAL),
)
