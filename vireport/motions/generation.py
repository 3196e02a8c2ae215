"""Voltage that the impacts of a family generate: of single impacts, their mean, and their sum over a second."""

from __future__ import annotations

from collections.abc import Iterable
from math import nan

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.motions.families import Family
from vireport.physics.energy import Membrane, generated_voltage
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]


class Generation(Struct, frozen=True, eq=False):
    """Voltage and energy that the motions of a family generate.

    Attributes
    ----------
    impacts_v : ndarray (n, N)
        U_imp - Uin of each impact of each motion [V], Eqs. (5.2)-(5.5).
    average_v : ndarray (n,)
        U_ave, the mean over the impacts, Eq. (5.1) [V].
    impacts_per_s : ndarray (n,)
        N f/k [1/s].
    """

    impacts_v: Floats
    average_v: Floats
    impacts_per_s: Floats

    __repr__ = brief

    @property
    def per_second_v(self) -> Floats:
        """Sum of U_imp - Uin over the impacts of a second [V/s]."""
        return self.average_v * self.impacts_per_s


def generation(family: Family, membrane: Membrane) -> Generation:
    """Evaluate Eqs. (5.1)-(5.5) for the motions of a family."""
    sweep = family.sweep
    # In a sweep over force or frequency the unit of velocity changes from motion to motion.
    unit = np.broadcast_to(sweep.device.velocity_unit(sweep.parameter, family.sweep_value), len(family.sweep_value))
    impacts = generated_voltage(unit[:, None] * family.velocity, membrane)
    return Generation(impacts, impacts.mean(axis=1), impact_rate(family))


def impact_rate(family: Family) -> Floats:
    """Impacts in a second of the motions of a family, N f/k, (n,) [1/s]."""
    at = family.sweep.device.at(family.sweep.parameter, family.sweep_value)
    frequency = np.broadcast_to(at[Parameter.FREQUENCY], len(family.x))
    return np.asarray(len(family.word) / family.word.periods * frequency)


class Rung(Struct, frozen=True):
    """Largest voltages of the stable motions of one word over a sweep.

    Attributes
    ----------
    word : Word
    ranges : tuple of (float, float)
        Ranges of the swept parameter over which they are stable, ascending.
    average_v, average_at : float
        Largest mean voltage of the impacts [V], nan without a membrane; the value of the swept parameter for it.
    per_second_v, per_second_at : float
        Largest sum over the impacts of a second [V/s], nan without a membrane; the value of the swept parameter for it.
    impacts_per_s : (float, float)
        Least and largest number of impacts in a second [1/s].
    """

    word: Word
    ranges: tuple[tuple[float, float], ...]
    average_v: float
    average_at: float
    per_second_v: float
    per_second_at: float
    impacts_per_s: tuple[float, float]


def ladder(families: Iterable[Family], membrane: Membrane | None) -> tuple[Rung, ...]:
    """The words that have stable motions, by voltage per second, the largest first; by impacts without a membrane."""
    stable = [family for family in families if family.stable_runs]
    words = dict.fromkeys(family.word for family in stable)
    rungs = (_rung([family for family in stable if family.word == word], membrane) for word in words)
    key = "impacts_per_s" if membrane is None else "per_second_v"
    return tuple(sorted(rungs, key=lambda rung: getattr(rung, key), reverse=True))


def _rung(families: list[Family], membrane: Membrane | None) -> Rung:
    """Largest voltages of the stable motions of families of one word."""
    value = np.concatenate([family.sweep_value[family.stable_mask] for family in families])
    rate = np.concatenate([impact_rate(family)[family.stable_mask] for family in families])
    average = np.full(len(value), nan)
    if membrane is not None:
        average = np.concatenate([generation(family, membrane).average_v[family.stable_mask] for family in families])
    # Without a membrane all averages are nan, of which argmax takes the first.
    best, most = int(np.argmax(average)), int(np.argmax(average * rate))
    return Rung(
        families[0].word,
        tuple(sorted(part for family in families for part in family.stable_ranges)),
        float(average[best]),
        float(value[best]),
        float(average[most] * rate[most]),
        float(value[most]),
        (float(rate.min()), float(rate.max())),
    )
