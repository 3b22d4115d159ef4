"""Crossings of films, people in groups, and what the bench says of the rides."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.benchmarks.claims import MET, MISSED, OURS
from cohelm.benchmarks.ride_claims import judge
from cohelm.benchmarks.rides import crowds
from cohelm.errors import ConfigError, PluginError, RecordingError
from cohelm.evaluation.external.crossings import ASIDE, DURATION, NEAR, SHORTEST, crossing
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.sweeps import ride_row
from cohelm.geometry import wrap_angle
from cohelm.recordings import read_trajectories
from cohelm.recordings.pedestrians.trajectories import trajectories_of
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario


def street(seconds=300.0, *, people=60):
    """Somebody every few seconds along x, to and fro, over 30 m, in a band of 6 m."""
    rng = np.random.default_rng(2)
    who, times, places = [], [], []
    for i in range(people):
        t = rng.uniform(0.0, seconds - 25.0) + 0.4 * np.arange(60)
        t = np.round(t / 0.4) * 0.4
        x = -15.0 + 1.3 * (t - t[0])
        places.append(np.column_stack([x if i % 2 else -x, np.full(60, rng.uniform(-3.0, 3.0))]))
        times.append(t)
        who.append(np.full(60, i))
    return trajectories_of(
        name="street", step=0.4, who=np.concatenate(who), time=np.concatenate(times),
        position=np.concatenate(places),
    )  # fmt: skip


def test_a_crossing_leads_over_the_flow_when_somebody_is_there():
    film = street()
    for seed in range(30):
        drawn = crossing(film, seed)
        way = drawn.goal - drawn.start[:2]
        length = np.hypot(*way)
        assert SHORTEST <= length <= 6.0 + 2.0 * ASIDE + 0.5
        assert abs(way[1]) > 0.99 * length  # people walk along x
        ahead = np.array([np.cos(drawn.start[2]), np.sin(drawn.start[2])])
        assert ahead @ way == pytest.approx(length, rel=1e-3)
        at = np.flatnonzero(film.id == drawn.meets)[0]
        met = [
            np.hypot(*(film.at(drawn.begin + s)[1][k] - drawn.start[:2] - 0.65 * s * way / length))
            for s in np.arange(0.0, length / 0.65, 0.1)
            for k in np.flatnonzero(film.at(drawn.begin + s)[0] == drawn.meets)
        ]
        assert min(met) < 0.2, at
        assert 0.0 <= drawn.begin <= film.time.max() - DURATION


def test_nobody_is_at_the_start_or_comes_out_of_nothing_on_the_line():
    film = street()
    for seed in range(30):
        drawn = crossing(film, seed)
        start, goal = drawn.start[:2], drawn.goal
        _, there, _ = film.at(drawn.begin)
        assert (np.hypot(*(there - start).T) >= ASIDE).all()
        middle = 0.5 * (start + goal)
        for k in (*film.first[:-1], *(film.first[1:] - 1)):
            if drawn.begin <= film.time[k] <= drawn.begin + DURATION:
                assert np.hypot(*(film.position[k] - middle)) > NEAR


def test_a_seed_draws_the_same_crossing_and_another_another():
    film = street()
    assert crossing(film, 3).begin == crossing(film, 3).begin
    assert len({crossing(film, seed).begin for seed in range(10)}) > 7


def test_a_film_that_cannot_be_crossed_is_refused():
    with pytest.raises(RecordingError, match="street"):
        crossing(street(40.0, people=3), 0)


def row(seed, *, outcome="reached", person=0, standing=0):
    return {
        "seed": seed, "outcome": outcome, "collisions_person": person, "time": 15.0,
        "time_empty_floor": 12.0, "standing_contacts": standing,
    }  # fmt: skip


def verdicts(rows):
    return judge(crowds.SPEC.claims, {"zara01, replayed": {OURS: Rides(rows)}})


@pytest.mark.parametrize(("hits", "stops"), [(2, 8), (3, 7), (0, 11)])
def test_the_verdicts_count_rides(hits, stops):
    rows = [row(i, outcome="collision", person=1) for i in range(hits)]
    rows += [row(i, outcome="stopped", standing=1) for i in range(hits, hits + stops)]
    rows += [row(i) for i in range(hits + stops, 200)]
    reached, moving = verdicts(rows)
    assert reached.result == (MISSED if hits + stops > 10 else MET)
    assert moving.result == (MISSED if hits > 2 else MET)


def test_crossings_that_broke_off_count_against_the_verdict():
    rows = [row(i) for i in range(197)] + [row(i, outcome="error") for i in range(197, 200)]
    reached, moving = verdicts(rows)
    assert reached.result == MET
    assert (moving.found, moving.result) == ("0 of 200, 3 ended by an error", MISSED)


@pytest.fixture
def film(tmp_path):
    walks = street()
    order = np.lexsort((walks.id.repeat(60), walks.time))
    who = walks.id.repeat(60)
    file = tmp_path / "street_obsmat.txt"
    file.write_text(
        "".join(
            f"{round(walks.time[k] / 0.04)} {who[k]} {walks.position[k, 0]} 0 "
            f"{walks.position[k, 1]} 0 0 0\n"
            for k in order
        )
    )
    return file


def test_every_planner_rides_the_same_crossing(film):
    bench = crowds.create(planners="dwa,ss_mpc_dcbf", films=str(film))
    (task,) = bench.tasks(range(4, 5))
    one, other = (ride.load() for ride in task)
    assert one.local_planner["use"] == "dwa"
    assert one.people == other.people
    assert (one.start, one.goal) == (other.start, other.goal)
    assert dict(task[0].columns) == {"scene": "street_obsmat, replayed", "planner": "dwa"}
    middle = 0.5 * (np.array(one.start[:2]) + one.goal)
    np.testing.assert_allclose(middle, crowds.MIDDLE, atol=0.01)
    drawn = crossing(read_trajectories(film), 4)
    assert wrap_angle(math.radians(one.start[2]) - drawn.start[2]) == pytest.approx(0.0, abs=0.01)


def test_what_there_is_not_is_refused_before_anything_is_ridden(monkeypatch, tmp_path):
    with pytest.raises(ConfigError, match="absent"):
        crowds.create(planners="dwa", films=str(tmp_path / "absent.txt"))
    monkeypatch.delenv("COHELM_DATA", raising=False)
    crowds._film.cache_clear()
    with pytest.raises(ConfigError, match="COHELM_DATA"):
        crowds.create(planners="dwa", films="zara01")


def test_an_unknown_planner_is_refused(film):
    with pytest.raises(PluginError, match="dwx"):
        crowds.create(planners="dwx", films=str(film))


@pytest.mark.slow
def test_a_crossing_is_ridden_marked_and_the_same_again(film):
    bench = crowds.create(planners="dwa", films=str(film), true_people=True)
    ((task,),) = bench.tasks(range(1))
    one, other = ride_row(task), ride_row(task)
    assert one.row["error"] == ""
    assert one.row["reacting_share"] == 0.0  # nobody reacts
    assert one.row["encounters"] >= 1
    assert one.row["time_empty_floor"] > 8.0
    assert math.isfinite(one.row["mean_distance"])
    assert one.arrays["series"].tobytes() == other.arrays["series"].tobytes()


def test_groups_walk_abreast_and_stand_in_a_ring():
    groups = "[{points: [[2, 7], [12, 7]], size: 5, speed: 1.1}, {points: [[7, 4]], size: 4}]"
    settings = [f"people.groups={groups}", "people.jitter=0", "people.model=social_force"]
    crowd = build_scenario(load_scenario("empty", settings), 0).world.crowd
    assert crowd.group.tolist() == [0] * 5 + [1] * 4
    assert set(crowd.preferred_speed[:5]) == {1.1}
    # three abreast 0.85 m apart, and two behind them
    np.testing.assert_allclose(sorted(crowd.position[:3, 1]), [6.15, 7.0, 7.85])
    np.testing.assert_allclose(crowd.position[:3, 0], 2.0)
    np.testing.assert_allclose(crowd.position[3:5, 0], 1.0)
    ring = crowd.position[5:] - [7.0, 4.0]
    np.testing.assert_allclose(np.hypot(*(ring - np.roll(ring, 1, axis=0)).T), 0.85)
    inwards = np.column_stack([np.cos(crowd.heading[5:]), np.sin(crowd.heading[5:])])
    np.testing.assert_allclose((inwards * ring).sum(axis=1), -np.hypot(*ring.T))


def test_groups_count_among_the_people_and_change_nobody_else():
    ways = "people.pedestrians=[{points: [[2, 5], [12, 5]]}]"
    groups = "people.groups=[{points: [[2, 9], [12, 9]], size: 3}]"
    alone = build_scenario(load_scenario("empty", [ways]), 0).world.crowd
    both = build_scenario(load_scenario("empty", [ways, groups]), 0).world.crowd
    assert len(both.radius) == 4
    assert both.group.tolist() == [-1, 0, 0, 0]
    assert alone.group is None
    assert both.preferred_speed[0] == alone.preferred_speed[0]
    assert len(set(both.preferred_speed[1:])) == 1
    for count, n in ((0, 0), (2, 2), (4, 4)):
        settings = [ways, groups, f"people.count={count}"]
        assert len(build_scenario(load_scenario("empty", settings), 0).world.crowd.radius) == n


@pytest.mark.data
@pytest.mark.parametrize("film", crowds.FILMS)
def test_every_seed_of_the_real_films_has_a_crossing(film):
    root = os.environ.get("COHELM_DATA")
    if not root or not (Path(root) / crowds.film_file(film)).is_file():
        pytest.skip("COHELM_DATA has no pedestrians")
    walks = read_trajectories(Path(root) / crowds.film_file(film))
    drawn = [crossing(walks, seed) for seed in range(200)]
    assert len({each.meets for each in drawn}) > 60
    length = [np.hypot(*(each.goal - each.start[:2])) for each in drawn]
    assert SHORTEST <= min(length) <= max(length) < 20.0
