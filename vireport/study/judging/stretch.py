"""How far the stable motions stretch the membranes, and how long a contact with a deflection of the radius lasts."""

from __future__ import annotations

import numpy as np

from vireport.base.errors import NumericalError
from vireport.design.sensitivity import contact_share
from vireport.physics.energy import MembraneStretch, impact_speed, stretch_of
from vireport.physics.groups import by_wall
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.impacts import followed
from vireport.text.alerts import Severity

DEMONSTRATED = 5.9
"""Area ratio at the areal strain of 488 % that has been demonstrated for a dielectric elastomer (Huang et al., Appl.
Phys. Lett. 100 (2012) 041911)."""

STATED_FIELD_V_M = 1e8
"""Breakdown field at which the thickness is stated that a voltage needs, where the membrane's material is not given: a
common one of dielectric elastomers."""


def stretch_at_design(results: Evidence) -> MembraneStretch | None:
    """How far the deepest impact of the stable 1:1 motions, or else of other motions, stretches a membrane.

    At the design point, or without one over the sweep; None where no stable motion or no ball mass is known.
    """
    solution = results.solution
    if solution.membrane is None or solution.stretch is not None or results.atlas is None:
        return solution.stretch
    try:
        depths = [float(impacts.deflection_m.value) for _, impacts in followed(results)]
    except NumericalError:  # none were followed at the design point
        return None
    return stretch_of(max(depths), solution.membrane) if depths else None


def severity_of(stretch: MembraneStretch | None) -> Severity | None:
    """Severity of the alert on a stretch: None up to a deflection of the radius, then a note, then a warning."""
    if stretch is None or stretch.depth_ratio <= 1:
        return None
    return Severity.WARNING if stretch.area_ratio > DEMONSTRATED else Severity.NOTE


def contact_at_radius(results: Evidence) -> float | None:
    """Duration of a contact that deflects a membrane by its radius, over the forcing period; the longer of both.

    With h >= 1 no shallower contact is shorter. None for h < 1, without a ball mass or stable motion, and where the
    restitution has no contact law or falls with the speed.
    """
    membrane, device, frequency = results.solution.membrane, results.solution.device, results.impacts[2]
    if membrane is None or not frequency.size or membrane.exponent < 1 or device.law is not None:
        return None
    at = impact_speed(np.array([membrane.active_radius_m]), membrane), membrane
    slowest = np.array([frequency.min()])
    shares = [contact_share(*at, r, slowest) for r in set(by_wall(device.restitution))]
    return max((share for share in shares if share is not None), default=None)
