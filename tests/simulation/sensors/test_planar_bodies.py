"""Outlines of people and their aids in planar scans, and that they are tracked."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.benchmarks.perception.walking_aids import WALKING, passage
from cohelm.evaluation.perception.recording_view import perception_of
from cohelm.scenarios.build import draw_kinds, statures_of, with_bodies
from cohelm.scenarios.pedestrian_spec import CrowdSpec
from cohelm.simulation.sensors import BodyKind, HumanBodies, outline_of, planar_discs
from cohelm.simulation.sensors.planar_bodies import RADIUS


@pytest.mark.parametrize("kind", BodyKind)
@pytest.mark.parametrize("swing", [-1.0, 0.0, 0.3])
def test_an_outline_stays_within_its_disc(kind, swing):
    x, y, r = outline_of(kind, swing, RADIUS[kind]).T
    assert (np.hypot(x, y) + r).max() <= RADIUS[kind] + 1e-9


def test_bodies_without_kinds_are_discs_as_before():
    bodies = HumanBodies.standing(np.array([[1.0, 2.0], [3.0, 4.0]]))
    assert planar_discs(bodies).tolist() == [[1.0, 2.0, 0.25], [3.0, 4.0, 0.25]]


def test_an_outline_turns_with_its_person():
    kind = np.array([int(BodyKind.WHEELCHAIR)])
    east = replace(HumanBodies.standing(np.zeros((1, 2))), kind=kind)
    north = replace(east, heading=np.array([np.pi / 2.0]))
    x, y, r = planar_discs(east).T
    assert planar_discs(north) == pytest.approx(np.column_stack([-y, x, r]))


def test_given_bodies_are_kept_and_shares_are_drawn():
    spec = CrowdSpec(
        pedestrians=[{"points": [(0, 0)], "body": "child"}], bodies={"walker": 0.5, "legs": 0.5}
    )
    kinds = draw_kinds(spec, 400, np.random.default_rng(0))
    assert kinds[0] == BodyKind.CHILD
    assert set(kinds[1:]) == {BodyKind.WALKER, BodyKind.LEGS}
    # Half of 399, within four standard deviations (10 each).
    assert abs(np.count_nonzero(kinds == BodyKind.WALKER) - 199.5) < 40
    assert draw_kinds(CrowdSpec(), 3, np.random.default_rng(0)) is None


def test_without_kinds_crowd_and_heights_stay():
    heights = np.array([1.6, 1.8])
    assert statures_of(None, heights) is heights
    assert with_bodies("crowd", None) == "crowd"


@pytest.mark.parametrize("kind", WALKING)
def test_people_of_all_kinds_who_walk_are_tracked(kind):
    found = passage(kind, 0, perception_of())
    assert found.tracked >= 0.9
