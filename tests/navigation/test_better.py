"""When another way is so much better that it replaces a path that is still good."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import Crowding, LiveObstacles, Path, WishReport
from cohelm.navigation.better import BetterParameters, Left, Lookout, judged, worth_a_look
from cohelm.navigation.question import Why

RULES = BetterParameters()
NONE = LiveObstacles(corner=[0, 0], occupied=np.zeros((100, 100)), version=0)
LOOK = Lookout(at=0.0, live=NONE)
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
        kept_score=kept,
    )


def why(path, look=LOOK, left=None, time=100.0):
    return judged(path, HERE, look, left, time=time, blocked_time=0.7, parameters=RULES)[0]


@pytest.mark.parametrize("kept", [10.0, 30.0, 200.0])
def test_a_way_must_save_a_share_and_some_metres(kept):
    least = kept * 0.88 - 1.0
    assert why(found(least - 1e-6, kept)) is Why.BETTER
    assert why(found(least + 1e-6, kept)) is None


def test_no_two_ways_are_each_much_better_than_the_other():
    rng = np.random.default_rng(0)
    for a, b in rng.uniform(0.0, 100.0, (500, 2)):
        assert not (why(found(a, b)) and why(found(b, a)))


def test_a_line_that_runs_beside_the_path_is_no_other_way():
    assert why(found(1.0, 100.0, bend(0.9))) is None
    assert why(found(1.0, 100.0, bend(1.3))) is Why.BETTER


def test_the_way_that_was_left_must_save_more_and_not_at_once():
    """Of 100 m it must save 1.1 · (12 + 1) = 14.3 m, and 20 s must have passed."""
    left = Left(points=bend(4.0), at=100.0)
    assert why(found(85.6, 100.0), left=left, time=119.9) is None
    assert why(found(85.6, 100.0), left=left, time=120.1) is Why.BETTER
    assert why(found(85.8, 100.0), left=left, time=120.1) is None
    elsewhere = Left(points=bend(-4.0), at=100.0)
    assert why(found(86.9, 100.0), left=elsewhere, time=100.1) is Why.BETTER


def test_a_path_that_is_blocked_out_of_sight_is_given_up_when_it_stays_so():
    shut = found(30.0, np.inf)
    look = LOOK
    for time, expected in [(10.0, None), (10.6, None), (10.8, Why.BLOCKED)]:
        reason, look = judged(shut, HERE, look, None, time=time, blocked_time=0.7, parameters=RULES)
        assert reason is expected
    _, opened = judged(
        found(30.0, 30.0), HERE, look, None, time=11.0, blocked_time=0.7, parameters=RULES
    )
    assert opened.shut_since == np.inf


def test_a_planner_that_does_not_compare_is_not_asked_again():
    reason, look = judged(
        found(0.0, None), HERE, LOOK, None, time=9.0, blocked_time=0.7, parameters=RULES
    )
    assert reason is None
    changed = Crowding(density=np.ones((2, 2)), resolution=1.0, X_MG=np.zeros(3), version=7)
    assert not worth_a_look(look, 100.0, NONE, changed, 0.05, RULES)


# ------------------------------------------------------------------ when to look


def with_block(cells, version=1, corner=(0, 0)):
    occupied = np.zeros((100, 100))
    occupied.flat[:cells] = 1
    return LiveObstacles(corner=np.array(corner), occupied=occupied, version=version)


def test_it_is_looked_only_when_something_changed_and_not_often():
    many = with_block(40)  # 40 · 0.05² = 0.1 m² > 0.05 m²
    assert not worth_a_look(LOOK, 100.0, NONE, None, 0.05, RULES)
    assert not worth_a_look(LOOK, 2.9, many, None, 0.05, RULES)
    assert worth_a_look(LOOK, 3.0, many, None, 0.05, RULES)
    few = with_block(19)
    assert not worth_a_look(LOOK, 3.0, few, None, 0.05, RULES)
    assert worth_a_look(replace(LOOK, shut_since=0.0), 3.0, NONE, None, 0.05, RULES)


def test_a_window_that_rolls_over_the_same_things_has_not_changed():
    occupied = np.zeros((100, 100))
    occupied[50:60, 50:60] = 1
    there = LiveObstacles(corner=[0, 0], occupied=occupied, version=3)
    rolled = LiveObstacles(
        corner=[20, 10], occupied=np.roll(occupied, (-20, -10), (0, 1)), version=4
    )
    look = replace(LOOK, live=there)
    assert not worth_a_look(look, 9.0, rolled, None, 0.05, RULES)
    gone = LiveObstacles(corner=[20, 10], occupied=np.zeros((100, 100)), version=5)
    assert worth_a_look(look, 9.0, gone, None, 0.05, RULES)


def test_news_of_crowds_is_a_reason_to_look():
    crowd = Crowding(density=np.ones((2, 2)), resolution=1.0, X_MG=np.zeros(3), version=1)
    assert worth_a_look(LOOK, 9.0, NONE, crowd, 0.05, RULES)
    assert not worth_a_look(replace(LOOK, crowding=crowd), 9.0, NONE, crowd, 0.05, RULES)
