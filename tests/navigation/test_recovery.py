"""Recovery stages: their order, their end, the rider's input."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.messages import Reason
from cohelm.navigation.recovery.parameters import RecoveryParameters
from cohelm.navigation.recovery.progress_checker import ProgressParameters
from cohelm.navigation.recovery.stages import (
    PeopleNearby,
    RecoveryContext,
    RecoveryStage,
    RecoveryState,
    after_waiting_at_goal,
    recovery_step,
)

TICK = 0.05
P = RecoveryParameters()
PACE = ProgressParameters()  # time allowance 3 s, progress 0.3 m
ORDER = [
    RecoveryStage.WAIT,
    RecoveryStage.REPLAN,
    RecoveryStage.BACK_UP,
    RecoveryStage.CREEP,
    RecoveryStage.ASK,
]


def situation(k, **changes):
    """Tick k of a chair that has stood at (5, 4) since time 0, without people near."""
    plain = RecoveryContext(
        time=k * TICK,
        position=np.array([5.0, 4.0]),
        stands=True,
        stalled_for=k * TICK,
        progress_at=0.0,
        planned_at=0.0,
        searched_at=0.0,
        deflection=np.zeros(2),
    )
    return replace(plain, **changes)


class Chair:
    """A chair that executes every action: it replans, and backs up at 0.2 m/s."""

    def __init__(self, parameters=P):
        self.parameters, self.memory, self.x, self.looked = parameters, None, 5.0, 0.0
        self.looks, self.log = [], []

    def run(self, ticks, change=lambda k: {}):
        for k in range(len(self.log), len(self.log) + ticks):
            given_ = {
                "position": np.array([self.x, 4.0]),
                "searched_at": self.looked,
                **change(k),
            }
            now = situation(k, **given_)
            done, self.memory = recovery_step(now, self.memory, self.parameters, PACE)
            self.log.append(done)
            if done.replans:
                self.looked = now.time
                self.looks.append(k)
            if done.back_up_distance > 0.0:
                self.x -= min(0.2 * TICK, done.back_up_distance)
        return self

    @property
    def stages(self):
        """(stage, first tick) in their order."""
        out = []
        for k, done in enumerate(self.log):
            if not out or out[-1][0] != done.stage:
                out.append((done.stage, k))
        return out


def test_while_the_ride_gets_on_nothing_is_done():
    done, memory = recovery_step(situation(59), None, P, PACE)  # 2.95 s
    assert (done.stage, memory) == (None, None)
    assert (done.replans, done.creeps, done.reverses, done.back_up_distance) == (
        False,
        False,
        False,
        0.0,
    )


def test_the_stages_come_in_their_order_and_at_their_times():
    chair = Chair().run(500, lambda k: {"rear_clearance": 0.4})
    # 3 s allowance, 1 s of waiting, 0.5 s on the new path, 0.37 m back at 0.2 m/s, 8 s of creeping
    times = [0, 60, 80, 90, 90 + 38, 128 + 160]
    assert [stage for stage, _ in chair.stages] == [None, *ORDER]
    assert [k for _, k in chair.stages] == pytest.approx(times, abs=1)


def test_where_nothing_is_known_to_be_free_behind_the_chair_does_not_back_up():
    for room in (0.0, 0.09):
        chair = Chair().run(500, lambda k, room=room: {"rear_clearance": room})
        assert [stage for stage, _ in chair.stages] == [None, *[s for s in ORDER if s != "back_up"]]
        assert not any(done.reverses for done in chair.log)


def test_backing_up_is_never_farther_than_allowed_and_ends_where_the_room_does():
    far = Chair().run(300, lambda k: {"rear_clearance": 5.0})
    assert 5.0 - far.x == pytest.approx(P.back_up, abs=0.05)
    stopped = Chair().run(300, lambda k: {"rear_clearance": 5.0 if k < 100 else 0.0})
    assert 5.0 - stopped.x == pytest.approx(10 * 0.2 * TICK, abs=0.02)
    to_goal = Chair().run(300, lambda k: {"rear_clearance": 5.0, "goal_behind": 0.22})
    assert 5.0 - to_goal.x == pytest.approx(0.22, abs=0.05)
    never = Chair(P.model_copy(update={"back_up": 0.0})).run(300, lambda k: {"rear_clearance": 5.0})
    assert never.x == 5.0


@pytest.mark.parametrize(
    ("people", "seconds"),
    [(PeopleNearby.NONE, 1.0), (PeopleNearby.STANDING, 2.0), (PeopleNearby.WALKING, 8.0)],
)
def test_people_are_waited_for_and_those_who_walk_longest(people, seconds):
    chair = Chair().run(400, lambda k: {"people": people})
    (_, wait), (_, replan) = chair.stages[1:3]
    assert (replan - wait) * TICK == pytest.approx(seconds)


def test_a_new_path_does_not_start_the_waiting_anew():
    def planned(k):
        at = 7.5 * (k * TICK // 7.5)
        return {"people": PeopleNearby.WALKING, "planned_at": at, "progress_at": at}

    chair = Chair().run(400, planned)
    (_, wait), (_, replan) = chair.stages[1:3]
    assert (replan - wait) * TICK == pytest.approx(8.0)


def test_another_way_is_looked_for_once_a_stage_and_again_while_asking():
    chair = Chair().run(700, lambda k: {"rear_clearance": 0.4})
    ask = chair.stages[-1][1]
    early = [k for k in chair.looks if k < ask]
    assert len(early) == 2  # before backing up, and after it
    late = [k for k in chair.looks if k >= ask]
    assert np.diff(late) * TICK == pytest.approx([P.replan_interval] * (len(late) - 1))
    assert len(late) >= 3


def test_a_look_that_was_put_off_is_asked_for_until_it_is_taken():
    """Replanning rests for a while after each plan."""
    memory, asked = None, []
    for k in range(90):
        done, memory = recovery_step(situation(k), memory, P, PACE)  # searched_at stays 0
        asked.append(done.replans)
    assert asked.index(True) == 80
    assert all(asked[80:])


def test_a_chair_that_moves_on_a_new_path_is_given_time():
    chair = Chair().run(400, lambda k: {"stands": k < 80, "rear_clearance": 0.4})
    stages = dict(chair.stages)
    assert (stages[RecoveryStage.CREEP] - stages[RecoveryStage.REPLAN]) * TICK == pytest.approx(
        P.new_path_time
    )
    assert RecoveryStage.BACK_UP not in stages  # it backs up from a stand only


# ------------------------------------------------------------------ the end of it


def test_it_is_over_when_the_ride_has_got_on():
    def change(k):
        got_on = {"position": np.array([5.31, 4.0]), "progress_at": 3.5, "stalled_for": 0.0}
        return got_on if k >= 70 else {}

    chair = Chair().run(71, change)
    assert chair.log[69].stage is RecoveryStage.WAIT
    assert chair.log[70].stage is None
    assert chair.memory is None


def test_a_new_path_alone_is_not_getting_on():
    def change(k):
        late = {"planned_at": 4.0, "progress_at": 4.0, "stalled_for": k * TICK - 4.0}
        return late if k > 80 else {}

    chair = Chair().run(500, change)
    assert [stage for stage, _ in chair.stages] == [None, *[s for s in ORDER if s != "back_up"]]


def test_who_creeps_must_get_clear_of_the_place_not_only_come_back_to_it():
    def again(k, x):
        gone = {
            "planned_at": 7.0,
            "progress_at": 8.0,
            "stalled_for": 2.0,
            "position": np.array([x, 4.0]),
        }
        return {"rear_clearance": 0.4, **(gone if k >= 200 else {})}

    same = Chair().run(201, lambda k: again(k, 5.31))
    assert same.log[-1].stage is RecoveryStage.CREEP
    elsewhere = Chair().run(201, lambda k: again(k, 3.99))
    assert elsewhere.log[-1].stage is None


def test_another_wish_of_the_rider_ends_it():
    chair = Chair().run(400)
    assert chair.log[-1].stage is RecoveryStage.ASK
    chair.run(1, lambda k: {"requested_at": 20.0, "stalled_for": 0.0})
    assert chair.log[-1].stage is None


# ------------------------------------------------------------------ the rider's push


@pytest.mark.parametrize(
    ("deflection", "side"),
    [((0.8, 0.6), "left"), ((0.8, -0.6), "right"), ((1.0, 0.1), "none"), ((0.0, 1.0), "left")],
)
@pytest.mark.parametrize("at", [25, 70, 85, 100, 400])
def test_a_push_ends_waiting_at_once_and_its_side_is_taken(at, deflection, side):
    """After 1.25 s, before it counts as stalled; while waiting; re-planning; backing up; asking."""
    pushed = {"deflection": np.array(deflection)}
    chair = Chair().run(at, lambda k: {"rear_clearance": 0.4}).run(1, lambda k: pushed)
    assert (chair.log[-1].stage, chair.log[-1].side) == (RecoveryStage.CREEP, side)
    assert chair.log[-1].creeps
    assert chair.log[-1].back_up_distance == 0.0
    chair.run(20)  # let go
    assert (chair.log[-1].stage, chair.log[-1].side) == (RecoveryStage.CREEP, side)


def test_who_gets_itself_out_leads_and_else_the_hand_does():
    chair = Chair().run(500, lambda k: {"rear_clearance": 0.4})
    leads = {done.stage for done in chair.log if done.takes_over}
    assert leads == {RecoveryStage.BACK_UP, RecoveryStage.CREEP}


def test_who_pushes_a_chair_that_moves_is_in_no_tie():
    chair = Chair().run(50, lambda k: {"deflection": np.array([1.0, 0.0]), "stands": False})
    assert chair.memory is None


# ------------------------------------------------------------------ what is said


def test_each_stage_has_its_reason_and_a_chair_that_moves_early_needs_none():
    words = {}
    for done in Chair().run(500, lambda k: {"rear_clearance": 0.4}).log:
        words[done.stage] = (done.reason(stands=True), done.reason(stands=False))
    assert words == {
        None: (None, None),
        RecoveryStage.WAIT: (Reason.WAITING, None),
        RecoveryStage.REPLAN: (Reason.REPLANNING, None),
        RecoveryStage.BACK_UP: (Reason.BACKING_UP, Reason.BACKING_UP),
        RecoveryStage.CREEP: (Reason.CREEPING, Reason.CREEPING),
        RecoveryStage.ASK: (Reason.ASK_RIDER, Reason.ASK_RIDER),
    }


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_whatever_happens_it_ends_with_the_rider_and_goes_back_only_into_room(seed):
    """A chair that never gets on: no stage is come back to, but for the rider's push."""
    rng = np.random.default_rng(seed)
    memory, before = None, -1
    for k in range(int(rng.integers(100, 500))):
        room, pushes = rng.choice([0.0, 0.05, 0.2, 0.4]), rng.random() < 0.02
        now = situation(
            k,
            stands=bool(rng.random() < 0.7),
            people=list(PeopleNearby)[rng.integers(3)],
            rear_clearance=float(room),
            deflection=np.array([1.0, 0.5]) if pushes else np.zeros(2),
        )
        done, memory = recovery_step(now, memory, P, PACE)
        assert done.back_up_distance <= min(room, P.back_up)
        assert not done.reverses or room > 0.0
        place = -1 if done.stage is None else ORDER.index(done.stage)
        assert place >= before or pushes
        assert not pushes or place in {-1, ORDER.index(RecoveryStage.CREEP)}
        before = place


def test_after_a_wait_for_a_place_that_stays_taken_it_looks_for_another_way():
    state = RecoveryState(
        stage=RecoveryStage.WAIT_AT_GOAL, since=3.0, began=3.0, position=np.zeros(2)
    )
    after = after_waiting_at_goal(state, 13.0)
    assert after.stage is RecoveryStage.REPLAN
    assert after.has_waited_at_goal
    assert after.search_from == after.since == 13.0
