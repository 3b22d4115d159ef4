import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.geometry import transform
from cohelm.perception import Detections, KalmanTracker, ScanClusters
from cohelm.simulation.sensors.localisation import Localisation
from cohelm.testing import check_tracker

from .rays import Laser, box, observation, ride

R = 0.27


def still(_):
    return (0.0, 0.0, 0.0)


def nobody(_):
    return np.empty((0, 3))


def track(laser, discs_at, seconds, where=still):
    """(time, people) of each tick, through detector and tracker."""
    told = ride(laser, where, discs_at, seconds, ScanClusters(), KalmanTracker())
    return [(time, people) for time, people, _ in told]


def ids(ticks):
    return sorted({int(i) for _, people in ticks for i in people.id})


def nearest(people, point):
    return int(np.hypot(*(people.mean[:, :2] - point).T).argmin())


def sighting(time, positions, confidence=0.98):
    """What a detector would tell of whole bodies, without its points."""
    d = len(positions)
    return dataclasses.replace(
        Detections.empty(time, np.zeros(2)),
        position=np.reshape(positions, (-1, 2)),
        radius=np.full(d, R),
        deviation=np.full(d, 0.03),
        confidence=np.full(d, confidence),
    )


def test_fulfils_the_contract():
    check_tracker(KalmanTracker())


@pytest.mark.parametrize("localisation", [0.0, 1.0])
@pytest.mark.parametrize("away", [2.0, 4.0, 7.0])
def test_a_walker_is_one_track_with_the_right_velocity(away, localisation):
    def walker(t):
        return np.array([[away, -2.0 + 1.2 * t, R]])

    ticks = track(Laser(localisation=localisation), walker, 3.0)
    assert ids(ticks) == [0]
    # three scans, at 0, 0.1 and 0.2 s, confirm a track
    assert all(len(people) == 1 for time, people in ticks if time >= 0.2)
    late = [(walker(time)[0, :2], people.mean[0]) for time, people in ticks if time > 1.0]
    assert max(np.hypot(*(mean[:2] - true)) for true, mean in late) < 0.1
    assert max(np.hypot(*(mean[2:] - [0.0, 1.2])) for _, mean in late) < 0.2
    assert all(abs(people.heading[0] - np.pi / 2) < 0.2 for time, people in ticks if time > 1.0)


def test_two_who_cross_keep_their_ids():
    def crossing(t):
        return np.array([[4.0, -2.0 + t, R], [4.8, 2.0 - t, R]])

    ticks = track(Laser(), crossing, 4.0)
    assert ids(ticks) == [0, 1]
    _, first = ticks[10]
    _, last = ticks[-1]
    end = crossing(3.95)
    for k in range(2):
        who = first.id[nearest(first, crossing(0.5)[k, :2])]
        assert last.id[nearest(last, end[k, :2])] == who


def test_a_person_hidden_for_a_second_keeps_the_id():
    # a wall from y = −0.6 to 0.6 at x = 2 hides the walker at x = 4 from −1.2 + R to 1.2 − R
    screen = np.array([[2.0, -0.6, 2.0, 0.6]])
    ticks = track(Laser(segments=screen), lambda t: np.array([[4.0, -3.0 + 1.6 * t, R]]), 4.0)
    known = [people for time, people in ticks if time > 0.3]
    assert ids(ticks) == [0]
    # told for 0.8 s at least, and at once when seen again; hidden for 1.4 s
    assert sum(len(people) == 0 for people in known) <= 0.6 * 20
    known = [people for people in known if len(people)]
    # unsure while hidden, sure again at the end
    spread = [np.sqrt(people.covariance[0, 0, 0]) for people in known]
    assert max(spread) > 5.0 * spread[-1]
    assert min(people.confidence[0] for people in known) < known[-1].confidence[0]


def test_who_turns_back_within_half_a_second_keeps_the_id():
    def distracted(t):
        # 1.2 m/s, then −6 m/s² from 2.0 to 2.4 s, then −1.2 m/s
        s = min(max(t - 2.0, 0.0), 0.4)
        y = -2.0 + 1.2 * min(t, 2.0) + 1.2 * s - 3.0 * s**2 - 1.2 * max(t - 2.4, 0.0)
        return np.array([[4.0, y, R]])

    ticks = track(Laser(), distracted, 4.0)
    assert ids(ticks) == [0]
    for time, people in ticks:
        if time > 3.0:
            assert people.mean[0, 3] == pytest.approx(-1.2, abs=0.2)


def test_a_person_at_rest_keeps_the_last_heading_and_a_stranger_has_none():
    def stops(t):
        return np.array([[4.0, -1.0 + min(t, 1.5), R], [-3.0, 1.0, R]])

    ticks = track(Laser(localisation=1.0), stops, 5.0)
    _, last = ticks[-1]
    walked, stood = nearest(last, [4.0, 0.5]), nearest(last, [-3.0, 1.0])
    assert last.heading[walked] == pytest.approx(np.pi / 2, abs=0.3)
    assert np.isnan(last.heading[stood])
    assert np.hypot(*last.mean[walked, 2:]) < 0.15


@pytest.mark.parametrize("turn", [0.0, 0.5, 0.8])
def test_driving_past_boxes_shows_nobody(turn):
    boxes = np.concatenate([box(0.0, 1.5, 0.5, turn), box(2.0, -1.4, 0.6, turn)])
    laser = Laser(segments=boxes, localisation=1.0)
    ticks = track(laser, nobody, 9.0, where=lambda t: (-5.0 + t, 0.0, 0.2 * np.sin(t)))
    assert ids(ticks) == []


def test_an_empty_room_is_empty():
    ticks = track(Laser(localisation=1.0), nobody, 8.0, where=lambda t: (-4.0 + t, 0.0, 0.8 * t))
    assert ids(ticks) == []


def test_what_is_not_round_is_a_person_once_it_walks_and_no_more_when_it_stays():
    tracker, memory, told = KalmanTracker(), None, {}
    for tick in range(120):
        time = tick / 10
        at = [[3.0, min(time, 3.0)]]
        people, memory = tracker.track(
            observation(time), (sighting(time, at, confidence=0.1),), memory
        )
        told[time] = len(people)
    assert told[0.3] == 0
    assert told[2.5] == 1
    assert told[11.9] == 0


def test_seen_through_it_goes_sooner_than_hidden():
    tracker = KalmanTracker()
    memory = None
    for tick in range(10):
        time = tick / 10
        _, memory = tracker.track(observation(time), (sighting(time, [[4.0, 0.0]]),), memory)
    told, kept = {}, {}
    beams = np.radians(np.arange(-20, 21))
    far = 9.0 * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
    for name, points in (("unlooked", -far), ("through", far), ("hidden", far / 9.0)):
        state = memory
        for tick in range(10, 80):
            time = tick / 10
            seen = sighting(time, np.empty((0, 2)))
            seen = dataclasses.replace(
                seen,
                points=points,
                detection_of_return=np.full(len(points), -1),
                cluster_of_return=np.full(len(points), -1),
                mapped=np.zeros(len(points), dtype=bool),
            )
            people, state = tracker.track(observation(time), (seen,), state)
            if len(people):
                told[name] = time - 0.8
            if len(state):
                kept[name] = time - 0.8
    # patience of 2 s, seen-through time counted threefold, unlooked three and hidden two fifths
    assert kept["through"] == pytest.approx(2.0 / 3.0, abs=0.11)
    assert kept["unlooked"] == pytest.approx(2.0 / 0.6, abs=0.21)
    assert kept["hidden"] == pytest.approx(2.0 / 0.4, abs=0.21)
    # told while the place is known: q t³ / 3 + (σ_v t)² = 0.4² with σ_v ≈ 0.25 m/s, at 0.9 s
    assert told["hidden"] == told["unlooked"] == pytest.approx(0.9, abs=0.15)
    assert "through" not in told


def test_without_scans_it_predicts_and_gives_up():
    tracker, memory = KalmanTracker(), None
    for tick in range(12):
        time = tick / 10
        seen = sighting(time, [[4.0, time]])
        people, memory = tracker.track(observation(time), (seen,), memory)
    before = people
    people, same = tracker.track(observation(1.4), (), memory)
    ahead = 1.4 - 1.1
    assert identical(same, memory)
    assert people.mean[0, :2] == pytest.approx(
        before.mean[0, :2] + ahead * before.mean[0, 2:], abs=1e-9
    )
    assert people.covariance[0, 0, 0] > before.covariance[0, 0, 0]
    people, _ = tracker.track(observation(5.0), (), memory)
    assert len(people) == 0


@pytest.mark.parametrize("times", [[0.0] * 8, [5.0, 5.1, 5.2, 5.3, 5.25, 5.2, 5.1, 5.0]])
def test_a_clock_that_stands_or_stumbles_neither_crashes_nor_doubles(times):
    tracker, memory = KalmanTracker(), None
    for time in times:
        seen = sighting(time, [[4.0, 0.0]])
        people, memory = tracker.track(observation(time), (seen,), memory)
    assert people.id.tolist() == [0]
    assert np.isfinite(people.mean).all()


def test_a_clock_that_starts_anew_starts_anew_with_new_ids():
    tracker, memory = KalmanTracker(), None
    for time in (100.0, 100.1, 100.2, 0.0, 0.1, 0.2):
        seen = sighting(time, [[4.0, 0.0]])
        people, memory = tracker.track(observation(time), (seen,), memory)
    assert people.id.tolist() == [1]


def test_twin_runs_are_equal_and_memory_is_a_value():
    def walkers(t):
        return np.array([[4.0, -2.0 + t, R], [-3.0, 1.0, R]])

    runs = [track(Laser(localisation=1.0), walkers, 1.5) for _ in range(2)]
    assert identical(runs[0], runs[1])


def test_turning_the_world_turns_the_people():
    tracker = KalmanTracker()
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    told = []
    for world in (np.eye(2), turn):
        memory = None
        for tick in range(12):
            time = tick / 10
            at = np.array([[4.0, time], [2.0 - 0.5 * time, -2.0]]) @ world.T
            people, memory = tracker.track(observation(time), (sighting(time, at),), memory)
        told.append(people)
    assert told[1].mean[:, :2] == pytest.approx(told[0].mean[:, :2] @ turn.T)
    assert told[1].mean[:, 2:] == pytest.approx(told[0].mean[:, 2:] @ turn.T)
    assert told[1].heading - told[0].heading == pytest.approx(
        [np.pi / 2] * 2 - 2 * np.pi * (told[1].heading < told[0].heading)
    )


def test_ids_are_not_used_again_after_everyone_has_gone():
    tracker, memory = KalmanTracker(), None
    told = []
    for tick in range(90):
        time = tick / 10
        here = [[4.0, 0.0]] if not 20 <= tick < 70 else np.empty((0, 2))
        people, memory = tracker.track(observation(time), (sighting(time, here),), memory)
        told.append(people)
    assert len(told[60]) == len(memory) - 1 == 0
    assert told[15].id.tolist() == [0]
    assert told[-1].id.tolist() == [1]


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_detections_means_nothing(seed):
    rng = np.random.default_rng(seed)
    start, velocity = rng.uniform(-6.0, 6.0, (8, 2)), rng.normal(0.0, 0.8, (8, 2))
    tracker, memories = KalmanTracker(), [None, None]
    for tick in range(40):
        time = tick / 10
        at = start + time * velocity + 0.03 * rng.standard_normal((8, 2))
        at = at[rng.random(8) > 0.1]
        told = []
        for k, order in enumerate((np.arange(len(at)), rng.permutation(len(at)))):
            seen = sighting(time, at[order])
            people, memories[k] = tracker.track(observation(time), (seen,), memories[k])
            told.append(people)
        assert identical(told[0], told[1])
    assert identical(*memories)


@pytest.mark.parametrize("gap", [0.45, 0.7])
@pytest.mark.parametrize("merging", [False, True])
def test_two_who_pass_close_keep_their_ids_for_many_seeds(gap, merging):
    tracker = KalmanTracker()
    kept = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        memory, told = None, []
        for tick in range(40):
            time = tick / 10
            at = np.array([[4.0, -2.0 + time], [4.0 + gap, 2.0 - time]])
            noisy = at + 0.04 * rng.standard_normal((2, 2))
            if merging and np.hypot(*(at[0] - at[1])) < 0.75:
                noisy = noisy.mean(axis=0, keepdims=True)
            people, memory = tracker.track(observation(time), (sighting(time, noisy),), memory)
            told.append(people)
        first = [told[8].id[nearest(told[8], p)] for p in ([4.0, -1.2], [4.0 + gap, 1.2])]
        last = [told[-1].id[nearest(told[-1], p)] for p in (at[0], at[1])]
        kept += first == last and len(ids(enumerate(told))) == 2
    assert kept == 20


@pytest.mark.parametrize("hidden", [1.0, 2.0])
def test_one_who_walks_behind_another_keeps_the_id(hidden):
    tracker, memory = KalmanTracker(), None
    rng = np.random.default_rng(0)
    beams = np.radians(np.linspace(-60, 60, 241))
    screen = 2.0 * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
    told = []
    for tick in range(80):
        time = tick / 10
        at = np.array([[5.0, -3.0 + 1.1 * time]]) + 0.03 * rng.standard_normal((1, 2))
        gone = 2.0 <= time < 2.0 + hidden
        seen = sighting(time, np.empty((0, 2)) if gone else at)
        if gone:
            seen = dataclasses.replace(
                seen,
                points=screen,
                detection_of_return=np.full(len(screen), -1),
                cluster_of_return=np.full(len(screen), -1),
                mapped=np.zeros(len(screen), dtype=bool),
            )
        people, memory = tracker.track(observation(time), (seen,), memory)
        told.append((time, people))
    assert ids(told) == [0]
    assert len(told[-1][1]) == 1


@pytest.mark.parametrize("rate", [2.5, 5.0, 15.0, 40.0])
def test_any_rate_will_do(rate):
    tracker, memory = KalmanTracker(), None
    rng = np.random.default_rng(1)
    told = []
    time = 0.0
    while time < 8.0:
        at = np.array([[-3.0 + 1.2 * time, 2.0], [4.0, 3.0 - 0.8 * time]])
        noisy = at + 0.03 * rng.standard_normal((2, 2))
        people, memory = tracker.track(observation(time), (sighting(time, noisy),), memory)
        told.append((time, people))
        time += rng.uniform(0.6, 1.4) / rate
    assert ids(told) == [0, 1]
    assert all(len(people) == 2 for when, people in told if when > 1.3)
    _, people = told[-1]
    south, east = np.argsort(people.mean[:, 1])
    for k, velocity in ((south, [0.0, -0.8]), (east, [1.2, 0.0])):
        sure = np.sqrt(np.diag(people.covariance[k])[2:])
        assert np.all(np.abs(people.mean[k, 2:] - velocity) < 3.0 * sure)
        assert sure.max() < 0.25


def test_a_pause_of_two_seconds_does_not_make_a_stranger():
    tracker, memory = KalmanTracker(), None
    told = []
    for time in [*np.arange(0.0, 2.0, 0.1), *np.arange(4.0, 6.0, 0.1)]:
        seen = sighting(time, [[3.0, -3.0 + 1.0 * time]])
        people, memory = tracker.track(observation(time), (seen,), memory)
        told.append((time, people))
    assert ids(told) == [0]


def test_sensors_that_take_turns_and_come_late_make_one_track():
    tracker, memory = KalmanTracker(), None
    rng = np.random.default_rng(2)
    told = []
    for tick in range(120):  # 30 Hz; LiDAR at 10 Hz, camera at 15 Hz and 60 ms late
        time = tick / 30
        seen = []
        for every, late in ((3, 0.0), (2, 0.06)):
            if tick % every == 0:
                at = np.array([[3.0, -2.0 + 1.2 * (time - late)]])
                seen.append(sighting(time - late, at + 0.02 * rng.standard_normal((1, 2))))
        people, memory = tracker.track(observation(time), tuple(seen), memory)
        told.append((time, people))
    assert ids(told) == [0]
    _, people = told[-1]
    assert people.mean[0] == pytest.approx([3.0, -2.0 + 1.2 * time, 0.0, 1.2], abs=0.2)


def test_what_stands_still_does_not_walk_for_a_localiser_that_wanders():
    # an error of 3 cm and 1° at most, correlated over 2 s, of a robot among posts up to 8 m away
    tracker = KalmanTracker()
    posts = np.array([[2.0, 1.0], [-4.0, 3.0], [0.0, -6.0], [7.5, -2.0], [-5.5, -5.5]])
    for seed in range(10):
        rng = np.random.default_rng(seed)
        localisation = Localisation()
        error = localisation.first(rng)
        memory = None
        for tick in range(300):
            time = tick / 10
            error = localisation.after(error, 0.1, rng)
            at = transform(error, posts) + 0.02 * rng.standard_normal(posts.shape)
            seen = sighting(time, at, confidence=0.5)
            people, memory = tracker.track(observation(time, error), (seen,), memory)
            assert len(people) == 0


def torso(k, x=3.0, **changes):
    """Sighting number k of a round object with eight returns, at (x, 0)."""
    seen = dataclasses.replace(
        sighting(0.1 * k, [[x, 0.0]]),
        points=np.column_stack([np.full(8, x - 0.25), np.linspace(-0.2, 0.2, 8)]),
        detection_of_return=np.zeros(8, dtype=np.int64),
        mapped=np.zeros(8, dtype=bool),
        cluster_of_return=np.zeros(8, dtype=np.int64),
        ellipse=np.array([[x, 0.0, R, R, 0.0]]),
        arrival_log_odds=np.zeros(1),
    )
    return dataclasses.replace(seen, **changes)


@pytest.mark.parametrize(("same_view", "told"), [(True, True), (False, False)])
def test_a_walker_of_a_wrong_shape_ends_before_a_driving_scanner(same_view, told):
    """The visible part of furniture moves along it, then shows as what it is."""
    tracker, memory = KalmanTracker(), None
    for k in range(24):
        clear = k < 16
        seen = torso(
            k, x=3.0 + 0.1 * k, confidence=np.array([0.9 if clear else 0.02]), same_view=same_view
        )
        people, memory = tracker.track(observation(seen.time), (seen,), memory)
        assert k != 15 or len(people) == 1
    assert bool(len(people)) == told
