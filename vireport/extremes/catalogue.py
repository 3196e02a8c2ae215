"""The catalogue of extreme cases: each answered within its bound, or refused with the reason, and no third way.

An exception other than a refusal, a warning of numpy, a number that is not finite and an error beyond its bound all
make a case fail, with its text in place of what was found.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from math import isfinite
from time import perf_counter
from typing import TYPE_CHECKING

from vireport.analysis import SMALLEST_LOSS
from vireport.errors import NumericalError, VireportError
from vireport.extremes.cases import motion_cases
from vireport.extremes.checks import Case, Finding, NotThereError, base_of
from vireport.extremes.critical import critical_cases
from vireport.extremes.simulation import simulation_cases
from vireport.scenario import Loaded

if TYPE_CHECKING:
    from vireport.progress import Progress

__all__ = ["Case", "Finding", "Outcome", "catalogue", "judge", "run_catalogue"]

INSTALL = {"numba": "pip install 'vireport[simulation]'", "mpmath": "pip install 'vireport[accuracy]'"}
"""How to get the packages that cases need."""

ABSENT = "does not occur"
"""How the text of a case begins that does not apply to the device, and passes."""

LONGEST = 60.0
"""Seconds after which a case counts as hanging; none takes more than three."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a case.

    Attributes
    ----------
    case : Case
    found : str
        The answer, the reason of the refusal, or what went wrong.
    error : float or None
        Relative, against 40 digits; None where it is a refusal or an invariant.
    bound : float or None
        That the error may have.
    seconds : float
    passed : bool
    needs : str
        Why it was left out; empty if it was run.
    """

    case: Case
    found: str
    error: float | None
    bound: float | None
    seconds: float
    passed: bool
    needs: str = ""

    @property
    def verdict(self) -> str:
        """``passed``, ``failed`` or ``left out``."""
        return "left out" if self.needs else "passed" if self.passed else "failed"


def catalogue(loaded: Loaded | None = None) -> tuple[Case, ...]:
    """Every case around the device of a scenario, or around the paper's.

    Raises
    ------
    NumericalError
        If the device is itself one of those that are refused.
    """
    base = base_of(loaded)
    if 1 - base.device.restitution < SMALLEST_LOSS:
        raise NumericalError(
            f"device.restitution: {base.device.restitution!r} is itself an extreme that is refused: impacts with "
            f"hardly any loss (allowed here: at most 1 - {SMALLEST_LOSS:g})"
        )
    return (*motion_cases(base), *critical_cases(base), *simulation_cases(base))


def run_catalogue(loaded: Loaded | None = None, progress: Progress | None = None) -> tuple[Outcome, ...]:
    """Run every case around the device of a scenario, or around the paper's.

    Parameters
    ----------
    loaded : Loaded or None
        From `scenario.load`.
    progress : callable, optional
        Told each case as it begins.
    """
    return _judged(catalogue(loaded), progress)


def _judged(cases: Iterable[Case], progress: Progress | None) -> tuple[Outcome, ...]:
    found = []
    for case in cases:
        if progress is not None:
            progress(f"{case.group}: {case.name}")
        found.append(judge(case))
    return tuple(found)


def judge(case: Case) -> Outcome:
    """Run one case, with every warning an error, and decide whether it passed."""
    missing = [name for name in case.needs if find_spec(name) is None]
    if missing:
        why = f"needs {' and '.join(missing)}: {', '.join(INSTALL.get(name, name) for name in missing)}"
        return Outcome(case, "", None, None, 0.0, False, why)
    start = perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = case.run()
        passed, text = _passed(case, found), found.text
    except VireportError as refusal:
        found, text = Finding(""), " ".join(str(refusal).split())
        passed = bool(case.refusal) and re.search(case.refusal, text) is not None
        text = f"refused: {text}"
    except NotThereError as absent:
        found, text, passed = Finding(""), f"{ABSENT}: {absent}", True
    except Exception as fault:
        # Whatever it is, it is the finding: a catalogue that stops at the first fault would not show the next.
        found, text, passed = Finding(""), f"{type(fault).__name__}: {fault}", False
    seconds = perf_counter() - start
    if seconds > LONGEST:
        text, passed = f"took {seconds:.0f} s: {text}", False
    return Outcome(case, text, found.error, found.bound, seconds, passed)


def _passed(case: Case, found: Finding) -> bool:
    """Whether an answer is right: one was asked for, nothing else is wrong with it, and its error is in its bound."""
    if case.refusal and not case.answers:
        return False
    if found.error is None:
        return found.right
    return found.right and isfinite(found.error) and found.bound is not None and found.error <= found.bound
