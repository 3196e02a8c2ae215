"""The steps of a run that look for what other starts come to, and what must hold for each."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.scenario.keys import value_at
from vireport.study.plan import (
    DESIGN,
    NUMBA,
    OUTPUT,
    PICTURES,
    AddedBlock,
    AddedTask,
    DeclaredStep,
    Precondition,
    Task,
)

MOMENTS = AddedTask(
    "from-rest-moments", "from which share of the moments of switching on it is reached, or with which ramp"
)
WINDOWS = AddedTask("from-rest-windows", "where that changes, around the design point and along the sweep")
SHOCK = AddedTask("shock", "the least jump of the velocity that leads out of the stable motion")
COEXISTENCE = AddedTask(
    "coexistence", "the stable motions of the design point: starts that come to each, least shock of each"
)
JITTER = AddedTask("jitter", "how far random kicks spread phases, velocities and voltages of the stable motion")
BASINS = AddedTask("basins", "which impacts on the bottom membrane lead to which motion")
FIGURE_SHOCKS = AddedTask("figure-shocks", "what shocks lead to, by their moment and size (figure-shocks)")
FIGURE_BASIN = AddedTask("figure-basin", "basins of attraction on the section of impacts (figure-basin)")

NO_BLOCK, BLOCK = "the scenario has no disturbances block (an empty one is enough)", AddedBlock("disturbances")

HAS_BLOCK = Precondition(lambda scenario, _: value_at(scenario, "disturbances"), NO_BLOCK, adds=BLOCK)
COMPARED = Precondition(
    lambda scenario, formats: (
        value_at(scenario, "disturbances") or (formats and scenario.requirements and scenario.requirements.allowed)
    ),
    NO_BLOCK,
    adds=BLOCK,
)
AT_ONCE = Precondition(
    lambda scenario, _: value_at(scenario, "disturbances.ramp_periods") == 0,
    "with a ramp it depends on the moment at which the force sets in (disturbances.ramp_periods: 0 has it)",
)
KICKED = Precondition(
    lambda scenario, _: (
        value_at(scenario, "disturbances.jitter_m_s") or value_at(scenario, "disturbances.jitter_restitution")
    ),
    "neither disturbances.jitter_m_s nor disturbances.jitter_restitution is given",
)
DRAWN = Precondition(lambda scenario, _: value_at(scenario, "disturbances.basin"), "disturbances.basin is false")
WANTED = Precondition(
    lambda scenario, formats: formats or (scenario.requirements and scenario.requirements.allowed), OUTPUT.otherwise
)


def _judged(key: str) -> Precondition:
    """The precondition that an output or a requirement needs a step; a verdict alone needs neither shocks nor kicks."""
    return Precondition(
        lambda scenario, formats: formats or value_at(scenario, f"requirements.{key}") is not None,
        OUTPUT.otherwise,
    )


SHOCK_JUDGED, JITTER_JUDGED = _judged("survives_shock_m_s"), _judged("phase_jitter_at_most_deg")
RAMPED = Precondition(
    # Without a ramp, the first moment has the outcome that the study finds for a ball from rest anyway.
    lambda scenario, formats: formats or value_at(scenario, "disturbances.ramp_periods"),
    OUTPUT.otherwise,
)


def steps() -> Iterator[DeclaredStep]:
    """The six steps in their order, and the two figures."""
    # In this order, as each uses what those before it have found: the shock of the 1:1 motion is not looked for again
    # among coexisting motions, and basins are those of the motions that were recognised there.
    has_disturbances, basin = "the scenario has a disturbances block", "disturbances.basin is true"
    yield DeclaredStep(MOMENTS, (HAS_BLOCK, DESIGN, RAMPED), has_disturbances)
    yield DeclaredStep(WINDOWS, (HAS_BLOCK, AT_ONCE, NUMBA, OUTPUT), has_disturbances)
    yield DeclaredStep(SHOCK, (HAS_BLOCK, DESIGN, NUMBA, SHOCK_JUDGED), has_disturbances)
    why = "a disturbances block, or a word that is required, asks for it"
    yield DeclaredStep(COEXISTENCE, (COMPARED, DESIGN, NUMBA, WANTED), why)
    yield DeclaredStep(JITTER, (HAS_BLOCK, KICKED, DESIGN, JITTER_JUDGED), "one of disturbances.jitter_... is given")
    yield DeclaredStep(BASINS, (DESIGN, NUMBA, OUTPUT), basin, (DRAWN,))
    yield DeclaredStep(FIGURE_SHOCKS, (HAS_BLOCK, DESIGN, NUMBA, PICTURES), has_disturbances, before=Task.FIGURE_CYCLE)
    yield DeclaredStep(FIGURE_BASIN, (DESIGN, NUMBA, PICTURES), basin, (DRAWN,), before=Task.FIGURE_CYCLE)
