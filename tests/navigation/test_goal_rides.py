"""Rides to goals in narrow places: passed by, behind, beside the path, occupied."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.maps import write_map
from cohelm.messages import Reason
from cohelm.navigation import Navigator, RecoveryStage
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing.scenes import room, walkers

CORRIDOR = [(4.0, 0.0, 9.0, 3.4), (4.0, 4.6, 9.0, 8.0)]
"""Of 1.2 m about y = 4: the chair, 1.11 m long and 0.61 m wide, cannot turn in it."""

BLIND_ALLEY = [(4.0, 0.0, 12.0, 3.4), (4.0, 4.6, 12.0, 8.0)]
"""The same up to the end of the room, where it cannot turn either."""


@pytest.fixture
def drive(tmp_path):
    """Ride through a room with ``boxes``; ``goal`` is a function of the true pose."""

    def run(seconds, *, goal, boxes=CORRIDOR, people=lambda t: [], start=(2.0, 4.0, 0), **keys):
        write_map(room(boxes=boxes), tmp_path / "room.yaml")
        scenario = {
            "map": str(tmp_path / "room.yaml"),
            "start": list(start),
            "goal": [10.5, 4.0],
            "mode": "autonomous",
            "tracker": "given",
            **keys,
        }
        file = tmp_path / "ride.yaml"
        file.write_text("\n".join(f"{key}: {value}" for key, value in scenario.items()))
        setup = build_scenario(load_scenario(file), 0)
        world, navigator, ticks = World(setup.world, 0), Navigator(setup.navigator), []
        truths, request = [], setup.request
        while world.truth.time < seconds and not (ticks and ticks[-1].arrived):
            wanted = np.array(goal(world.truth.pose))
            if not np.array_equal(wanted, request.goal):
                request = replace(request, goal=wanted)
            them = walkers(people(world.truth.time), time=world.truth.time, source="given")
            observation = replace(world.observe(), people=them)
            ticks.append(navigator.step(observation, request, ticks[-1] if ticks else None))
            truths.append(world.truth)
            world.advance(ticks[-1].decision)
        assert not any(truth.hit_wall for truth in truths)
        return ticks, truths

    return run


def goal_change(at, first, then):
    """Goal as a function of the pose: ``first`` until the chair is at x = ``at``, then ``then``."""
    goals = [first]

    def goal(pose):
        if pose[0] > at:
            goals.append(then)
        return goals[-1]

    return goal


def stages(ticks):
    return {tick.recovery.stage for tick in ticks if tick.recovery}


@pytest.mark.slow
def test_a_goal_metres_behind_in_a_corridor_is_backed_up_to_along_the_track(drive):
    """The goal changes once the chair is at x = 7.5, from the end of the room to 2.5 m behind."""
    ticks, truths = drive(60.0, goal=goal_change(7.5, (10.5, 4.0), (5.0, 4.0)), boxes=BLIND_ALLEY)
    assert ticks[-1].arrived
    assert RecoveryStage.REVERSE in stages(ticks)
    assert Reason.REVERSING in {tick.decision.reason for tick in ticks}
    assert max(truth.pose[0] for truth in truths) < 10.0
    assert all(abs(truth.pose[2]) < 0.5 for truth in truths)  # it never turned about


def test_a_chair_does_not_drive_away_from_a_path_that_begins_behind_it(drive):
    """It brakes in comfort from 0.8 m/s and creeps at most; it used to drive on to x = 10.9."""
    _, truths = drive(11.5, goal=goal_change(7.5, (10.5, 4.0), (5.0, 4.0)), boxes=BLIND_ALLEY)
    changed = next(truth.time for truth in truths if truth.pose[0] > 7.5)
    assert truths[-1].time > changed + 3.0
    assert max(truth.pose[0] for truth in truths) < 8.6


@pytest.mark.slow
def test_room_to_turn_ahead_is_not_driven_to_where_the_track_leads_back(drive):
    """The corridor ends 1.5 m ahead; the chair backs up, within the time that turning had."""
    ticks, truths = drive(60.0, goal=goal_change(7.5, (10.5, 4.0), (5.0, 4.0)))
    assert ticks[-1].arrived
    assert RecoveryStage.REVERSE in stages(ticks)
    assert all(abs(truth.pose[2]) < 0.5 for truth in truths)  # it never turned about
    assert max(truth.pose[0] for truth in truths) < 9.0  # the end of the corridor
    changed = next(truth.time for truth in truths if truth.pose[0] > 7.5)
    assert truths[-1].time < changed + 20.0


@pytest.mark.slow
def test_a_goal_just_passed_is_backed_up_to_at_once(drive):
    """The goal changes to 0.7 m behind: nearer than 1.5 m, so nothing is waited for."""
    ticks, truths = drive(40.0, goal=goal_change(7.5, (10.5, 4.0), (6.8, 4.0)))
    assert ticks[-1].arrived
    changed = next(truth.time for truth in truths if truth.pose[0] > 7.5)
    assert truths[-1].time < changed + 12.0  # 0.2 m/s, after stopping from 0.8 m/s
    assert max(truth.pose[0] for truth in truths) < 8.4


@pytest.mark.slow
def test_a_person_at_the_goal_is_waited_for_and_the_place_then_taken(drive):
    """They stand at the goal till 16 s, and walk away to the side."""

    def people(t):
        away = max(t - 16.0, 0.0)
        return [(10.5, 4.0 + min(0.8 * away, 3.0), 0.0, 0.8 if 0.0 < away < 3.75 else 0.0)]

    ticks, truths = drive(50.0, goal=lambda pose: (10.5, 4.0), people=people)
    assert ticks[-1].arrived
    waiting = [tick for tick in ticks if tick.decision.reason is Reason.GOAL_OCCUPIED]
    assert len(waiting) > 20
    assert stages(ticks) <= {None, RecoveryStage.WAIT_AT_GOAL, RecoveryStage.WAIT}
    body = float(ticks[0].people.radius[0])
    nearest = max(truth.pose[0] for truth in truths if truth.time < 16.0)
    assert 10.5 - body - (nearest + 0.65) >= 0.4  # outside the person's space
    assert truths[-1].time < 16.0 + 12.0


@pytest.mark.slow
def test_a_goal_beside_the_chairs_course_is_met_not_passed(drive):
    """The goal changes by 0.2 m to the side when the chair is 1 m before it."""
    ticks, truths = drive(40.0, goal=goal_change(9.5, (10.5, 4.0), (10.5, 4.2)))
    assert ticks[-1].arrived
    assert max(truth.pose[0] for truth in truths) < 10.7
