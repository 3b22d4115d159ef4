"""Objects that stand free cannot vanish; behind or out of the view of something they may."""

import math

import numpy as np
import pytest

from cohelm.health.sweeps import NO_OBJECTS, update_free_objects

BEAMS = 360
STEP = 2.0 * math.pi / BEAMS
ANGLES = -math.pi + STEP * np.arange(BEAMS)
PERIOD = 0.1
STANDS = np.zeros(3)


def sweep(*discs, wall=math.inf):
    """Ranges (b,) to discs (x, y, radius) before a round wall, m."""
    out = np.full(BEAMS, wall)
    for x, y, radius in discs:
        along = x * np.cos(ANGLES) + y * np.sin(ANGLES)
        aside = np.abs(y * np.cos(ANGLES) - x * np.sin(ANGLES))
        met = (aside < radius) & (along > 0.0)
        near = along - np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
        out = np.where(met, np.minimum(out, near), out)
    return out


def blind(ranges, half):
    """Ranges with a sector about the front that reads free."""
    return np.where(np.abs(ANGLES) <= half, math.inf, ranges)


def vanishes(sweeps, pose=lambda time: STANDS, first=-math.pi):
    """Time at which an object has vanished in one of the sweeps, s; None: never."""
    objects = NO_OBJECTS
    for i, ranges in enumerate(sweeps):
        time = PERIOD * i
        objects = update_free_objects(objects, ranges, first, STEP, pose(time), time)
        if objects.vanished(time):
            return time
    return None


PERSON = (3.0, 0.2, 0.25)


@pytest.mark.parametrize("wall", [math.inf, 8.0])
def test_who_is_gone_at_once_has_vanished_after_two_sweeps(wall):
    there, gone = sweep(PERSON, wall=wall), sweep(wall=wall)
    assert vanishes([there] * 5 + [gone] * 5) == pytest.approx(0.6)


def test_who_stays_walks_or_is_passed_by_the_chair_has_not():
    assert vanishes([sweep(PERSON)] * 20) is None
    assert vanishes([sweep((4.0, -2.0 + 0.15 * i, 0.25)) for i in range(30)]) is None
    # The chair drives by at 1 m/s and turns.
    poses = [np.array([PERIOD * i, 0.0, 0.05 * i]) for i in range(40)]
    seen = []
    for x, y, turn in poses:
        dx, dy = 4.0 - x, 1.5 - y
        c, s = math.cos(turn), math.sin(turn)
        seen.append(sweep((c * dx + s * dy, c * dy - s * dx, 0.25)))
    assert vanishes(seen, lambda time: poses[round(time / PERIOD)]) is None


def test_a_walker_into_a_sector_that_reads_free_vanishes():
    walker = [sweep((4.0, 3.5 - 0.1 * i, 0.25)) for i in range(40)]
    assert vanishes(walker) is None
    time = vanishes([blind(each, math.radians(20.0)) for each in walker])
    # At its edge, 1.46 m aside, the walker is cut from 0.25 m before to 0.25 m behind the middle.
    assert 1.8 <= time <= 2.7


def test_who_walks_behind_something_is_hidden():
    """A pillar 1 m before the walker, as wide as it takes to cover everything within reach."""
    pillar = (2.0, 0.0, 0.8)
    assert vanishes([sweep((4.0, 3.0 - 0.1 * i, 0.25), pillar) for i in range(40)]) is None


def test_what_no_beam_sees_is_unknown_not_gone():
    there = sweep(PERSON)
    assert vanishes([there] * 5 + [np.full(BEAMS, math.nan)] * 5) is None
    assert vanishes([there] * 5 + [np.zeros(BEAMS)] * 5) is None


def test_what_leaves_the_field_of_view_or_is_far_or_thin_has_not_vanished():
    half = slice(BEAMS // 4, 3 * BEAMS // 4)  # ±90°
    turned = [
        sweep((3.0 * math.cos(a), 3.0 * math.sin(a), 0.25))[half] for a in np.arange(0, 3, 0.1)
    ]
    poses = [np.array([0.0, 0.0, -0.1 * i]) for i in range(len(turned))]
    assert vanishes(turned, lambda time: poses[round(time / PERIOD)], -math.pi / 2.0) is None
    for other in ((7.0, 0.0, 0.3), (3.0, 0.0, 0.05)):
        assert vanishes([sweep(other)] * 5 + [sweep()] * 5) is None
