"""The plane of shocks: each pixel is an outcome, and the arrow ends where the least shock is."""

from __future__ import annotations

import numpy as np
import pytest
from figure_cases import ROOT, texts_of
from matplotlib.colors import to_rgb

from vireport.design.from_rest import Destination
from vireport.figures.pictures import pictures
from vireport.findings.outcomes.shocks_figure import LEAST, MANIFOLD, OWN
from vireport.scenario.loading import load
from vireport.study.study import analyse

NOT_REACHED = "excitation.amplitude_n=3.6", "disturbances={}"


@pytest.mark.slow
def test_the_plane_of_shocks_shows_what_was_found() -> None:
    """At 3.6 N, where the device does not come to the motion from rest and some shocks lead back there."""
    study = analyse(load(ROOT / "examples" / "inclined-forcing.yaml", NOT_REACHED), ["png"])
    assert study.switched_on.from_rest.destination is Destination.REST_CYCLE
    (drawn,) = [picture for picture in pictures(study) if picture.name == "figure-shocks"]
    axes, withstood = drawn.figure.axes[0], study.outcomes.withstood
    (image,) = axes.images
    pixels = np.asarray(image.get_array())
    returned = np.isclose(pixels, to_rgb(OWN)).all(axis=2)
    assert f"{100 * returned.mean():.1f} % of them return" in drawn.caption
    least = withstood.jump_m_s
    assert f"The least that leads out, {least:.2f} m/s" in drawn.caption
    rows = np.linspace(*image.get_extent()[2:], len(pixels))
    assert returned[np.abs(rows) < 0.99 * least].all()
    assert not returned.all()
    (arrow,) = [line for line in axes.lines if line.get_color() == LEAST["color"]]
    assert abs(arrow.get_ydata()[1]) == pytest.approx(least, rel=1e-12)
    manifold = [line for line in axes.lines if line.get_color() == MANIFOLD["color"]]
    nearest = min(np.abs(line.get_ydata()).min() for line in manifold)
    assert nearest == pytest.approx(least, rel=0.02)
    assert {"least shock", "BT every forcing period"} <= set(texts_of(drawn.figure))
