"""Hints at what was probably meant by an unknown key, or by a text where a number belongs.

Units are the usual slip, so they are looked for first: a scenario's key with another unit, without one, or by
its symbol in equations. Nothing is ever corrected silently; these are words for a message.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from difflib import get_close_matches
from math import pi

from vireport.scenario.document import join, scalar

# Factor to the unit of a scenario's keys, by the text that follows a number or ends a key, in lower case.
_LENGTHS = {"m": 1, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "km": 1e3}
_LENGTHS |= {"in": 0.0254, "inch": 0.0254, "ft": 0.3048}
_MASSES = {"kg": 1, "g": 1e-3, "mg": 1e-6, "ug": 1e-9, "t": 1e3, "lb": 0.45359237}
_TURNS = 1 / (2 * pi)
_UNITS: dict[str, dict[str, float]] = {
    "m": _LENGTHS,
    "kg": _MASSES,
    "N": {"n": 1, "mn": 1e-3, "kn": 1e3, "un": 1e-6, "lbf": 4.4482216152605},
    "Hz": {"hz": 1, "khz": 1e3, "rad_s": _TURNS, "rad/s": _TURNS, "rad": _TURNS, "rpm": 1 / 60},
    "deg": {"deg": 1, "°": 1, "degree": 1, "degrees": 1, "rad": 180 / pi, "radians": 180 / pi},
    "V": {"v": 1, "kv": 1e3, "mv": 1e-3, "volt": 1, "volts": 1},
    "%": {"%": 1, "percent": 1, "per cent": 1},
    "m/s^2": {"m_s2": 1, "m/s2": 1, "m/s^2": 1, "g": 9.80665, "cm_s2": 1e-2},
}
_DISPLAYED = {"kn": "kN", "mn": "mN", "un": "uN", "khz": "kHz", "kv": "kV", "mv": "mV", "rad_s": "rad/s"}
# Other words for a scenario's keys, in lower case, without the unit.
_WORDS = {
    "angle": "inclination_deg",
    "beta": "inclination_deg",
    "tilt": "inclination_deg",
    "omega": "frequency_hz",
    "angular_frequency": "frequency_hz",
    "freq": "frequency_hz",
    "force": "amplitude_n",
    "forcing": "amplitude_n",
    "force_amplitude": "amplitude_n",
    "distance": "length_m",
    "gap": "length_m",
    "spacing": "length_m",
    "coefficient_of_restitution": "restitution",
    "voltage": "bias_voltage_v",
    "version": "schema_version",
    "schema": "schema_version",
    "start": "from",
    "begin": "from",
    "min": "from",
    "end": "to",
    "stop": "to",
    "max": "to",
    "mass": "capsule_mass_kg",
    "name": "title",
    "tol": "tolerance",
    "bifurcation": "diagram",
}
_SYMBOLS = {
    "M": "capsule_mass_kg",
    "m": "ball_mass_kg",
    "s": "length_m",
    "r": "restitution",
    "F": "amplitude_n",
    "f": "frequency_hz",
    "ω": "frequency_hz",
    "β": "inclination_deg",
    "g": "gravity_m_s2",
    "n": "period_ratio",
    "K": "stiffness",
    "h": "exponent",
    "Rc": "active_radius_m",
    "rb": "ball_radius_m",
    "Uin": "bias_voltage_v",
}
_SUFFIX = {"m": "_m", "kg": "_kg", "N": "_n", "Hz": "_hz", "deg": "_deg", "V": "_v", "%": "_percent", "m/s^2": "_m_s2"}
_NUMBER = r"[-+]?(?:\.\d+|\d+(?:\.\d*)?)(?:[eE][-+]?\d+)?"
_WITH_UNIT = re.compile(rf"({_NUMBER})\s*([^\d\s.,:_'+*-][^\d]*\d?)")
_LONGEST_KEY = 60  # characters; what is longer is no slip of a key of ours


def for_key(block: str, key: str, value: object, units: dict[str, str]) -> str:
    """Say which key was probably meant by an unknown one; "" where there is no telling.

    Parameters
    ----------
    block, key : str
        Dotted path of the block that the key stands in, and the key, in quotes if it is no plain name.
    value : object
        The value of the key as read.
    units : dict of str to str
        Unit of every key, or "", by its dotted path.
    """
    if len(key) > _LONGEST_KEY:
        return ""
    if key.strip("'") in units and "." in key:
        return " with a dot in it; a key within a block is written indented below the block's name"
    if (block, key) == ("", "map"):
        return "; a file with a map is computed by 'vireport map FILE'"
    odd = next((letter for letter in key if ord(letter) > 127 and letter.isprintable()), None)
    strange = f"; it contains '{odd}' ({unicodedata.name(odd, 'no name')})" if odd else ""
    target, advice = key_meant(block, key, value, units)
    if not target:
        return strange
    at, name = _split(target)
    return f"{strange}; did you mean '{name if at == block else target}'?{advice}"


def key_meant(block: str, key: str, value: object, units: dict[str, str]) -> tuple[str, str]:
    """Find the path of the key that was probably meant by an unknown one, and advice on its unit; "" for neither.

    Parameters are those of `for_key`.
    """
    plain = key.strip("'").replace("-", "_").replace(" ", "_")
    target, advice = _by_unit(plain, value, block, units)
    # A key with this name in another block is meant before one that begins like it.
    if elsewhere := "" if join(block, plain) in units else _nearest(plain, block, units):
        target, advice = elsewhere, ""
    if not target:
        other_word = _nearest(_SYMBOLS.get(plain) or _WORDS.get(plain.lower()) or "", block, units)
        target = (
            (other_word if _split(other_word)[0] == block else "")
            or _nearest(closest(plain, [name for at, name in map(_split, units) if at == block]), block, units)
            or other_word
            or _nearest(closest(plain, {_split(path)[1] for path in units}), block, units)
        )
    return target, advice


def _by_unit(key: str, value: object, block: str, units: dict[str, str]) -> tuple[str, str]:
    """Find the path of a key that is written without its unit or with another one, and advice on the unit."""
    lower = key.lower()
    unit_of = {_split(path)[1]: unit for path, unit in units.items() if unit in _SUFFIX}
    named = reversed(unit_of.items())  # the first one counts: that of the input, not of its tolerance
    stems = {name.removesuffix(_SUFFIX[unit]): name for name, unit in named} | _WORDS
    for stem, name in sorted(stems.items(), key=lambda item: -len(item[0])):
        unit = unit_of.get(name)
        if unit is None or not (lower == stem or lower.startswith(f"{stem}_")):
            continue
        written_unit = lower.removeprefix(stem).strip("_")
        if not written_unit and stem in ("omega", "angular_frequency"):
            written_unit = "rad_s"
        factor = _UNITS[unit].get(written_unit) if written_unit else 1
        if factor is not None:
            advice = "" if factor == 1 else _conversion(written_unit, factor, unit, value, name)
            return _nearest(name, block, units), advice
    return "", ""


def _conversion(written_unit: str, factor: float, unit: str, value: object, name: str) -> str:
    text = f" It is in {unit}: 1 {_DISPLAYED.get(written_unit, written_unit)} is {factor:.6g} {unit}"
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300:
        text += f", so {name}: {value * factor:.9g}"
    return text


def _split(path: str) -> tuple[str, str]:
    """The block of a key and its name in it, from its path."""
    block, _, name = path.rpartition(".")
    return block, name


def _nearest(name: str, block: str, units: dict[str, str]) -> str:
    """Path of a key by its name, in this block rather than in another."""
    place = join(block, name) if name else ""
    if place in units:
        return place
    return next((path for path in units if name and _split(path)[1] == name), "")


def closest(word: str, choices: Iterable[str]) -> str:
    """Return the choice that is spelled most alike, whatever the case; "" if none is alike."""
    lower = {choice.lower(): choice for choice in sorted(choices)}
    alike = get_close_matches(word.lower()[:_LONGEST_KEY], lower, n=1, cutoff=0.7)
    return lower[alike[0]] if alike else ""


def for_number(text: str, quoted: bool, unit: str) -> str:
    """Say how to write the number that a text probably means; "" where there is no telling.

    Examples
    --------
    >>> for_number("0,5", False, "m")
    '; write 0.5, with a decimal point'
    >>> for_number("700 mm", False, "m")
    '; the unit stands in the key, write 0.7'
    """
    text = text.strip().replace("\u2212", "-")
    if _is_number(text):
        how = "without quotes" if quoted else "with the '-' of the keyboard"
        return f"; write {text}, {how}"
    if re.fullmatch(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", text):
        return f"; write {text.replace(',', '.')}, with a decimal point"
    bare = re.sub(r"(?<=\d)[ _',\u00a0\u2009\u202f](?=\d)", "", text)
    if bare != text and _is_number(bare):
        return f"; write {bare}, without separators"
    split = _WITH_UNIT.fullmatch(text.replace(",", "."))
    if split:
        number, written_unit = split[1], split[2].strip().lower()
        factor = _UNITS.get(unit, {}).get(written_unit)
        exact = "" if factor is None else f", write {float(number) * factor:.9g}"
        return f"; the unit stands in the key{exact}"
    if re.fullmatch(r"[0-9.\s()*/+^pieE-]+", text) and re.search(r"[*/^]|pi", text):
        return "; expressions are not evaluated, write the number"
    return ""


def _is_number(text: str) -> bool:
    return isinstance(scalar(text), (int, float)) and not isinstance(scalar(text), bool)
