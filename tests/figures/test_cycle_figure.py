"""The electrical cycle of the impacts: what is drawn encloses the energy that the results have."""

from __future__ import annotations

import numpy as np
import pytest
from figure_cases import ROOT, assert_readable, texts_of

from vireport import analyse, load
from vireport.figures.cycle import picture

FILM = "device.membrane={thickness_m: 1e-3, relative_permittivity: 4.7, breakdown_field_v_m: 1e8}"


def drawn(*over: str):
    study = analyse(load(ROOT / "examples/design-point.yaml", (FILM, *over)))
    return study, picture(study)


@pytest.mark.parametrize(
    "over", [[], ["inclination_deg=0", "device.length_m=0.36"], ["inclination_deg=5", "device.length_m=0.33"]]
)
def test_the_areas_that_are_drawn_are_the_energies(over: list[str]) -> None:
    study, cycles = drawn(*over)
    design = study.solution.design
    row = np.argmax(np.where(design.motions.stable_mask, design.conversion_by_motion.power_mw, 0))
    energies = design.conversion_by_motion.energy_bottom_j[row], design.conversion_by_motion.energy_top_j[row]
    for axes, energy, where in zip(cycles.figure.axes, energies, ("bottom", "top"), strict=True):
        assert axes.get_xlabel() == "charge [nC]"
        assert axes.get_ylabel() == ("voltage [kV]" if where == "bottom" else "")
        lines = axes.get_lines()[:3]
        charge, volts = (np.concatenate([line.get_data()[k][:-1] for line in lines]) for k in (0, 1))
        area = abs(np.dot(charge, np.roll(volts, 1)) - np.dot(volts, np.roll(charge, 1))) / 2
        assert area * 1e-6 == pytest.approx(energy, rel=1e-12)
        assert f"impact on the {where}: area {1e3 * energy:.3g} mJ" in axes.get_title(loc="left")
        assert axes.get_ylim()[1] > volts.max()
        assert axes.get_xlim()[1] > charge.max()


@pytest.mark.parametrize(("field", "there"), [(1e8, False), (2e7, True)])
def test_the_voltage_of_breakdown_is_drawn_where_it_is_reached(field: float, there: bool) -> None:
    _, cycles = drawn(f"device.membrane.breakdown_field_v_m={field}")
    assert ("breakdown" in texts_of(cycles.figure)) is there
    assert [len(axes.get_lines()) for axes in cycles.figure.axes] == [3 + there] * 2
    assert_readable(cycles.figure)


def test_without_a_stable_motion_nothing_is_drawn() -> None:
    study, cycles = drawn("device.length_m=0.1")
    assert study.plan.runs("figure-cycle")
    assert cycles is None
    assert "figure-cycle" not in {step.task for step in analyse(load(ROOT / "examples/design-point.yaml")).plan.steps}
