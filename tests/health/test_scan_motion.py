"""Motion between two sweeps: what walls show, and what a corridor cannot."""

import numpy as np
import pytest

from cohelm.geometry import compose
from cohelm.health.scan_motion import Sweep, scan_motion

BEAMS = 360
STEP = 2.0 * np.pi / BEAMS


def sweep(pose, half=(3.0, 4.0), rng=None):
    """Sweep in a box about the origin with half sides, m; +inf sides make a corridor."""
    a = pose[2] - np.pi + STEP * np.arange(BEAMS)
    c, s = np.cos(a), np.sin(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.where(c > 0, half[0] - pose[0], half[0] + pose[0]) / np.abs(c)
        y = np.where(s > 0, half[1] - pose[1], half[1] + pose[1]) / np.abs(s)
    ranges = np.fmin(np.where(np.isfinite(x), x, np.inf), np.where(np.isfinite(y), y, np.inf))
    if rng is not None:
        ranges = ranges + 0.01 * rng.standard_normal(BEAMS)
    return Sweep(np.where(ranges > 10.0, np.inf, ranges), -np.pi, STEP)


START = np.array([0.3, -0.5, 0.2])


@pytest.mark.parametrize("motion", [(0.3, 0.0, 0.0), (0.1, 0.05, 0.3), (0.0, 0.0, -0.4)])
def test_the_motion_is_found_from_a_wrong_guess(motion):
    rng = np.random.default_rng(1)
    now = sweep(compose(START, np.array(motion)), rng=rng)
    error = np.array([0.2, -0.1, 0.08])
    found = scan_motion(sweep(START, rng=rng), now, motion + error)
    # the prior of four points at the guess against about thirty pulls by an eighth of the error
    np.testing.assert_allclose(found.motion, motion, atol=0.03)
    assert found.inliers > 0.9


def test_a_corridor_keeps_the_guess_along_it():
    here, corridor = np.array([0.0, 0.2, 0.0]), (np.inf, 1.5)
    now = sweep(compose(here, np.array([0.3, 0.1, 0.0])), corridor)
    found = scan_motion(sweep(here, corridor), now, np.array([0.5, 0.0, 0.0]))
    assert found.motion[0] == pytest.approx(0.5, abs=0.05)
    assert found.motion[1] == pytest.approx(0.1, abs=0.02)


def test_different_rooms_do_not_fit():
    found = scan_motion(sweep(START), sweep(START, (1.2, 7.0)), np.zeros(3))
    assert found.inliers < 0.4
