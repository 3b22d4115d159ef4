"""Replacement of a usable path by a much better one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.messages import Crowding, LiveObstacles, Path, WishReport
from cohelm.navigation.replanning.path_switching import (
    AbandonedPath,
    SwitchingParameters,
    SwitchingState,
    evaluate_candidate,
    should_search,
)
from cohelm.navigation.replanning.route_query import PlanReason

RULES = SwitchingParameters()
NONE = LiveObstacles(corner=[0, 0], occupied=np.zeros((100, 100)), version=0)
LOOK = SwitchingState(at=0.0, live=NONE)
HERE = np.array([[0.0, 0.0], [20.0, 0.0]])


def bend(aside):
    """From (0, 0) to (20, 0), ``aside`` of the straight line in between."""
    return np.array([[0.0, 0.0], [5.0, aside], [15.0, aside], [20.0, 0.0]])


def found(score, kept, points=None):
    points = bend(4.0) if points is None else points
    return Path(
        points=points,
        length=22.0,
        cost=22.0,
        method="test",
        wishes=WishReport(closest=[]),
        without_wishes=points,
        score=score,
        previous_score=kept,
    )


def why(path, look=LOOK, left=None, time=100.0):
    return evaluate_candidate(
        path, HERE, look, left, time=time, blocked_time=0.7, parameters=RULES
    )[0]


def searches(state, time, live, crowding):
    grid = SimpleNamespace(resolution=0.05)
    query = SimpleNamespace(time=time, live=live, crowding=crowding, grid=grid)
    return should_search(state, query, RULES)


@pytest.mark.parametrize("kept", [10.0, 30.0, 200.0])
def test_a_better_path_must_save_a_share_and_some_metres(kept):
    least = kept * 0.88 - 1.0
    assert why(found(least - 1e-6, kept)) is PlanReason.BETTER
    assert why(found(least + 1e-6, kept)) is None


def test_no_two_paths_are_each_much_better_than_the_other():
    rng = np.random.default_rng(0)
    for a, b in rng.uniform(0.0, 100.0, (500, 2)):
        assert not (why(found(a, b)) and why(found(b, a)))


def test_a_line_close_beside_the_path_is_no_other_path():
    assert why(found(1.0, 100.0, bend(0.9))) is None
    assert why(found(1.0, 100.0, bend(1.3))) is PlanReason.BETTER


def test_the_abandoned_path_must_save_more_and_not_at_once():
    """Of 100 m it must save 1.1 · (12 + 1) = 14.3 m, and 20 s must have passed."""
    left = AbandonedPath(points=bend(4.0), at=100.0)
    assert why(found(85.6, 100.0), left=left, time=119.9) is None
    assert why(found(85.6, 100.0), left=left, time=120.1) is PlanReason.BETTER
    assert why(found(85.8, 100.0), left=left, time=120.1) is None
    elsewhere = AbandonedPath(points=bend(-4.0), at=100.0)
    assert why(found(86.9, 100.0), left=elsewhere, time=100.1) is PlanReason.BETTER


def test_a_path_that_is_blocked_out_of_sight_is_given_up_when_it_stays_so():
    shut = found(30.0, np.inf)
    look = LOOK
    for time, expected in [(10.0, None), (10.6, None), (10.8, PlanReason.BLOCKED)]:
        reason, look = evaluate_candidate(
            shut, HERE, look, None, time=time, blocked_time=0.7, parameters=RULES
        )
        assert reason is expected
    _, opened = evaluate_candidate(
        found(30.0, 30.0), HERE, look, None, time=11.0, blocked_time=0.7, parameters=RULES
    )
    assert opened.blocked_since == np.inf


def test_a_planner_that_does_not_compare_is_not_asked_again():
    reason, look = evaluate_candidate(
        found(0.0, None), HERE, LOOK, None, time=9.0, blocked_time=0.7, parameters=RULES
    )
    assert reason is None
    changed = Crowding(density=np.ones((2, 2)), resolution=1.0, X_MG=np.zeros(3), version=7)
    assert not searches(look, 100.0, NONE, changed)


# ------------------------------------------------------------------ when to search


def with_block(cells, version=1, corner=(0, 0)):
    occupied = np.zeros((100, 100))
    occupied.flat[:cells] = 1
    return LiveObstacles(corner=np.array(corner), occupied=occupied, version=version)


def test_a_search_needs_a_change_and_is_rare():
    many = with_block(40)  # 40 · 0.05² = 0.1 m² > 0.05 m²
    assert not searches(LOOK, 100.0, NONE, None)
    assert not searches(LOOK, 2.9, many, None)
    assert searches(LOOK, 3.0, many, None)
    few = with_block(19)
    assert not searches(LOOK, 3.0, few, None)
    assert searches(replace(LOOK, blocked_since=0.0), 3.0, NONE, None)


def test_a_window_that_rolls_over_the_same_things_has_not_changed():
    occupied = np.zeros((100, 100))
    occupied[50:60, 50:60] = 1
    there = LiveObstacles(corner=[0, 0], occupied=occupied, version=3)
    rolled = LiveObstacles(
        corner=[20, 10], occupied=np.roll(occupied, (-20, -10), (0, 1)), version=4
    )
    look = replace(LOOK, live=there)
    assert not searches(look, 9.0, rolled, None)
    gone = LiveObstacles(corner=[20, 10], occupied=np.zeros((100, 100)), version=5)
    assert searches(look, 9.0, gone, None)


def test_changed_crowding_is_a_reason_to_search():
    crowd = Crowding(density=np.ones((2, 2)), resolution=1.0, X_MG=np.zeros(3), version=1)
    assert searches(LOOK, 9.0, NONE, crowd)
    assert not searches(replace(LOOK, crowding=crowd), 9.0, NONE, crowd)
