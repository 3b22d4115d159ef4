"""Riders with eight directions, and riders who look away."""

import numpy as np
import pytest
from tests.simulation.riders.rider_views import STEP, pushes, swaying, view

from cohelm.plugins import build

PERSON = np.array([[2.0, 0.0, 0.0, 0.0, 0.25]])


def test_a_device_has_eight_directions_and_one_deflection():
    given = pushes("eight_directions", swaying(600))
    pushed = given[given.any(axis=1)]
    assert np.hypot(*pushed.T) == pytest.approx(0.5)
    eighths = np.arctan2(pushed[:, 1], pushed[:, 0]) / (np.pi / 4.0)
    assert np.allclose(eighths, np.rint(eighths))
    assert len(np.unique(np.rint(eighths))) >= 3
    ideal = pushes("ideal", swaying(600))[given.any(axis=1)]
    apart = np.arctan2(ideal[:, 1], ideal[:, 0]) - np.arctan2(pushed[:, 1], pushed[:, 0])
    assert np.abs((apart + np.pi) % (2.0 * np.pi) - np.pi).max() <= np.pi / 8.0 + 1e-9


@pytest.mark.parametrize("name", ["eight_directions", "looks_away"])
def test_a_limited_rider_needs_a_device_and_repeats_with_its_seed(name):
    views = swaying(200)
    np.testing.assert_array_equal(pushes(name, views, 3), pushes(name, views, 3))
    assert not pushes({"use": name, "base": "idle"}, views).any()
    rider = build("riders", {"use": name, "base": "none"})
    assert rider.act(views[0], None, np.random.default_rng(0)).command is None


def test_a_rider_who_looks_away_drives_as_if_nobody_were_there():
    steps = STEP * np.arange(400)
    # The first spell is drawn at the first call.
    met = [view(time, people=PERSON[: int(time > 0.0)]) for time in steps]
    alone = [view(time) for time in steps]
    always = {"use": "looks_away", "mean_gap": 1e-6, "duration": [59.0, 60.0]}
    assert np.array_equal(pushes(always, met), pushes("ideal", alone))
    away = (pushes("looks_away", met) == pushes("ideal", alone)).all(axis=1)
    assert 0.2 < away.mean() < 0.9
