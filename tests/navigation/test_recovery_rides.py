"""Rides without progress, from start to end: walls, given people, rider input."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.geometry import distance_to_polygon, inverse, transform
from cohelm.maps import write_map
from cohelm.messages import Mode, Reason, RiderCommand
from cohelm.navigation import Navigator, RecoveryStage
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing.scenes import BODY, room, walkers

CORRIDOR = [(4.0, 0.0, 9.0, 3.4), (4.0, 4.6, 9.0, 8.0)]
"""Of 1.2 m about y = 4, 5 m long, the only way between the ends of the room."""


class Log:
    """What happened, tick by tick."""

    def __init__(self, chair):
        self.chair, self.ticks, self.truths, self.gaps = chair, [], [], []

    def add(self, tick, truth, people):
        at = transform(inverse(truth.pose), people.mean[:, :2]).reshape(-1, 2)
        gaps = [distance_to_polygon(self.chair.outline, x, y) - BODY for x, y in at]
        self.ticks.append(tick)
        self.truths.append(truth)
        self.gaps.append(min(gaps, default=np.inf))

    @property
    def x(self):
        return np.array([truth.pose[0] for truth in self.truths])

    @property
    def y(self):
        return np.array([truth.pose[1] for truth in self.truths])

    @property
    def touched(self):
        return min(self.gaps) <= 0.0 or any(truth.hit_wall for truth in self.truths)

    @property
    def stages(self):
        """In their order, each as often as it was come to."""
        out = [None]
        for tick in self.ticks:
            stage = tick.recovery.stage if tick.recovery else None
            if stage != out[-1]:
                out.append(stage)
        return out[1:]

    def reasons(self, first=0.0, last=np.inf):
        return {t.decision.reason for t in self.ticks if first <= t.observation.time < last}

    def backwards(self):
        """How far the chair went backwards at a stretch at most, m."""
        speed = np.array([truth.twist[0] for truth in self.truths])
        farthest = gone = 0.0
        for v in speed:
            gone = gone - 0.05 * v if v < -0.02 else 0.0
            farthest = max(farthest, gone)
        return float(farthest)


@pytest.fixture
def drive(tmp_path):
    """Ride through a room with ``boxes`` until the goal or the time is reached."""

    def run(
        seconds, *, boxes, people=lambda t: [], stick=None, start=(2.0, 4.0, 0), stops=True, **keys
    ):
        write_map(room(boxes=boxes), tmp_path / "room.yaml")
        scenario = {
            "map": str(tmp_path / "room.yaml"),
            "start": list(start),
            "goal": [10.5, 4.0],
            "mode": "shared" if stick else "autonomous",
            "tracker": "given",
            **keys,
        }
        file = tmp_path / "ride.yaml"
        file.write_text("\n".join(f"{key}: {value}" for key, value in scenario.items()))
        stage = build_scenario(load_scenario(file), 0)
        world, navigator, tick = World(stage.world, 0), Navigator(stage.navigator), None
        log = Log(stage.robot)
        while world.truth.time < seconds and not (stops and tick and tick.arrived):
            time = world.truth.time
            them = walkers(people(time), time=time, source="given")
            seen = replace(world.observe(), people=them)
            if stick:
                rider = RiderCommand(heartbeat=time, deflection=np.array(stick(time)))
                seen = replace(seen, rider=rider)
            tick = navigator.step(seen, stage.request, tick)
            log.add(tick, world.truth, them)
            world.advance(tick.decision)
        return log

    return run


def in_order(stages, wanted):
    left = iter(stages)
    return all(stage in left for stage in wanted)


@pytest.mark.slow
def test_somebody_in_a_corridor_is_waited_for_and_the_ride_goes_on_when_they_leave(drive):
    """They stand at (7, 4) till 20 s, 15 s of which the chair is there; then they walk on."""

    def people(t):
        gone = max(t - 20.0, 0.0)
        if gone < 3.0:
            return [(7.0 + gone, 4.0, 1.0 if gone > 0.0 else 0.0, 0.0)]
        return [(10.0, 4.0 + min(gone - 3.0, 3.0), 0.0, 1.0 if gone < 6.0 else 0.0)]

    log = drive(60.0, boxes=CORRIDOR, people=people)
    assert log.ticks[-1].arrived
    assert not log.touched
    assert in_order(
        log.stages,
        [RecoveryStage.WAIT, RecoveryStage.REPLAN, RecoveryStage.BACK_UP, RecoveryStage.CREEP],
    )
    assert {Reason.WAITING, Reason.BACKING_UP, Reason.CREEPING} <= log.reasons()
    assert 0.1 < log.backwards() <= 0.5
    # on within 2 s of the moment when they have left
    stood, later = (float(np.interp(t, [k.time for k in log.truths], log.x)) for t in (20.0, 23.0))
    assert later > stood + 0.2


@pytest.mark.slow
def test_somebody_who_comes_out_of_the_corridor_is_only_waited_for(drive):
    """They come a little to the left of the chair, which moves to the right; step to the left."""

    def people(t):
        x, y = 8.5 - 0.8 * min(t, 6.0), 4.15 + min(max(t - 6.0, 0.0), 3.0)
        return [(x, y, *((-0.8, 0.0) if t < 6.0 else (0.0, 1.0 if t < 9.0 else 0.0)))]

    log = drive(60.0, boxes=CORRIDOR, people=people, start=(1.2, 4.0, 0))
    assert log.ticks[-1].arrived
    assert not log.touched
    assert set(log.stages) <= {None, RecoveryStage.WAIT}


@pytest.mark.slow
def test_a_goal_close_behind_is_backed_up_to(drive):
    """In 1.2 m the chair, 1.11 m long and 0.61 m wide, cannot turn about."""
    log = drive(30.0, boxes=CORRIDOR, start=(6.5, 4.0, 0), goal=[5.95, 4.0])
    assert log.ticks[-1].arrived
    assert not log.touched
    assert RecoveryStage.REVERSE in log.stages
    assert log.backwards() > 0.1


@pytest.mark.slow
def test_before_a_door_the_rider_is_asked_and_an_opened_door_is_gone_through(drive):
    door = "[{at: [7.0, 4.0], size: [0.1, 1.3], closed: [[2, 32]]}]"
    log = drive(60.0, boxes=CORRIDOR, doors=door)
    assert not log.touched
    assert Reason.ASK_RIDER in log.reasons(15.0, 32.0)
    standing = [k for k in log.ticks if 12.0 < k.observation.time < 30.0]
    assert all(k.decision.reason is not None for k in standing)  # never in silence
    assert log.ticks[-1].arrived
    assert log.truths[-1].time < 32.0 + 20.0


@pytest.mark.slow
def test_before_a_box_across_the_rider_is_asked_till_the_end(drive):
    box = "[{at: [7.0, 4.0], size: [0.4, 1.3]}]"
    log = drive(40.0, boxes=CORRIDOR, obstacles=box)
    assert not log.touched
    assert log.stages[-1] is RecoveryStage.ASK
    assert log.reasons(35.0) == {Reason.ASK_RIDER}
    assert log.backwards() <= 0.5


@pytest.mark.slow
def test_somebody_in_the_middle_of_a_corridor_is_passed_without_a_push(drive):
    """He stands in 2.1 m and leaves 0.8 m on both sides of him; the chair has 0.61 m."""
    boxes = [(4.0, 0.0, 9.0, 2.95), (4.0, 5.05, 9.0, 8.0)]
    log = drive(30.0, boxes=boxes, people=lambda t: [(6.5, 4.0, 0.0, 0.0)])
    assert log.ticks[-1].arrived
    assert min(log.gaps) > 0.05
    assert not log.stages


@pytest.mark.slow
@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_a_push_breaks_a_tie_within_a_second_and_its_side_is_tried(drive, side, sign):
    """Somebody in the middle of 2 m leaves 0.75 m on both sides, which the chair does not pass."""
    boxes = [(4.0, 0.0, 9.0, 3.0), (4.0, 5.0, 9.0, 8.0)]
    pushed = 14.0

    def stick(t):
        return (0.8, 0.6 * sign) if pushed <= t < pushed + 1.5 else (0.0, 0.0)

    log = drive(20.0, boxes=boxes, people=lambda t: [(6.5, 4.0, 0.0, 0.0)], stick=stick)
    before = [k for k in log.ticks if pushed - 1.0 < k.observation.time < pushed]
    assert all(k.recovery.stage is not None for k in before)
    after = [k for k in log.ticks if pushed <= k.observation.time < pushed + 1.0]
    assert after[0].recovery.stage is RecoveryStage.CREEP
    assert after[0].recovery.side == side
    moves = [t.twist for t in log.truths if pushed <= t.time < pushed + 1.0]
    assert max(np.hypot(twist[0], twist[2]) for twist in moves) > 0.05
    assert not log.touched


@pytest.mark.slow
@pytest.mark.parametrize("behind", ["nothing", "a wall", "a person"])
def test_the_chair_backs_up_only_where_it_is_free_behind(drive, behind):
    """A chair in the corridor, somebody 0.3 m ahead of it, and what may be behind it."""
    boxes, people = list(CORRIDOR), [(7.4, 4.0, 0.0, 0.0)]
    start = (6.2, 4.0, 0)
    if behind == "a wall":
        boxes.append((4.0, 3.4, 5.65, 4.6))  # 9 cm behind it
    if behind == "a person":
        people.append((5.1, 4.0, 0.0, 0.0))
    log = drive(15.0, boxes=boxes, people=lambda t: people, start=start)
    assert not log.touched
    backs = behind == "nothing"
    assert (RecoveryStage.BACK_UP in log.stages) is backs
    assert (log.backwards() > 0.1) is backs
    assert backs or not any(tick.recovery.reverses for tick in log.ticks)


def test_the_mode_of_these_rides(drive):
    log = drive(0.1, boxes=CORRIDOR)
    assert log.ticks[0].request.mode is Mode.AUTONOMOUS
    assert log.stages == []
