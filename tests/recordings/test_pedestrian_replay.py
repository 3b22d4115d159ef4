"""Filmed people enter, walk and leave as recorded; absent people cannot be touched."""

import dataclasses
import itertools
import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.geometry import transform
from cohelm.maps import FREE, OccupancyGrid
from cohelm.messages import Decision
from cohelm.recordings import read_trajectories
from cohelm.recordings.pedestrians.crowdnav import read_cases
from cohelm.recordings.pedestrians.replay import Replay
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import Crowd, CrowdScene, World, prepare_crowd

DT = 0.05
NOWHERE = OccupancyGrid(data=np.full((4, 4), FREE, dtype=np.int8), resolution=1.0, X_MG=np.zeros(3))


def scene(time=0.0, chair=(1e4, 1e4)):
    return CrowdScene(
        grid=NOWHERE,
        robot_position=np.array(chair),
        robot_velocity=np.zeros(2),
        robot_radius=0.5,
        time=time,
    )


def nobody():
    return Crowd(
        position=np.empty((0, 2)), velocity=np.empty((0, 2)), heading=np.empty(0),
        radius=np.empty(0), preferred_speed=np.empty(0), waypoints=np.empty((0, 1, 2)),
        target=np.empty(0, dtype=int), loop=np.empty(0, dtype=bool),
        sees_robot=np.empty(0, dtype=bool),
    )  # fmt: skip


def walker(**changes):
    """One who is in no film."""
    fields = {
        "position": [[3.0, 0.0]], "velocity": [[0.0, 0.0]], "heading": [0.0], "radius": [0.25],
        "preferred_speed": [1.0], "waypoints": [[[-5.0, 0.0]]], "target": [0], "loop": [False],
        "sees_robot": [True],
    }  # fmt: skip
    return Crowd(**{**fields, **changes})


@pytest.fixture
def film(tmp_path):
    """Two abreast, one who comes at 2 s and leaves at 4 s, one who is missed for 4 s."""
    rows = []
    for k in range(21):
        rows += [(10 * k, 1, 0.5 * k, 0.1 * np.sin(k)), (10 * k, 2, 0.5 * k, 1.0)]
        if 5 <= k <= 10:
            rows += [(10 * k, 3, 3.0, 6.0 - 0.4 * k)]
        if k <= 4 or k >= 14:
            rows += [(10 * k, 7, -2.0, 0.3 * k)]
    file = tmp_path / "lane_obsmat.txt"
    file.write_text("".join(f"{f} {who} {x} 0 {y} 0 0 0\n" for f, who, x, y in rows))
    (tmp_path / "lane_groups.txt").write_text("1 2\n")
    return file


def replayed(file, crowd=None, seconds=8.0, **changes):
    model = Replay(Replay.Parameters(file=str(file), **changes))
    rng = np.random.default_rng(0)
    crowds = [prepare_crowd(model, nobody() if crowd is None else crowd)]
    for k in range(round(seconds / DT)):
        crowds.append(model.step(crowds[-1], scene(k * DT), DT, rng))
    return crowds


def test_at_the_frames_people_are_where_they_were_noted(film):
    walks = read_trajectories(film)
    crowds = replayed(film)
    for k in range(0, len(crowds), 8):  # 0.4 s
        crowd = crowds[k]
        ids, noted, _ = walks.at(k * DT)
        assert walks.id[crowd.there].tolist() == ids.tolist()
        np.testing.assert_allclose(crowd.position[crowd.there], noted, atol=1e-9)
    rows = np.loadtxt(film)
    for frame, who, x, _, y, *_ in rows:
        at = crowds[round(frame / 10 * 0.4 / DT)].position[np.searchsorted(walks.id, who)]
        np.testing.assert_allclose(at, [x, y], atol=1e-9)


def test_people_come_and_leave_and_are_missed_as_noted(film):
    there = np.array([crowd.there for crowd in replayed(film)])
    assert there[:, :2].all()
    third = np.flatnonzero(there[:, 2]) * DT
    assert (third[0], third[-1]) == pytest.approx((2.0, 4.0))
    gone = np.flatnonzero(~there[:, 3]) * DT
    assert 1.6 < gone[0] < 1.7
    assert 5.5 < gone[-1] < 5.6


def test_people_who_walk_on_come_and_go_straight_and_are_else_as_noted(film):
    plain, longer = replayed(film), replayed(film, walk_on=1.2)
    for before, after in zip(plain, longer, strict=True):
        seen = before.there
        np.testing.assert_array_equal(after.position[seen], before.position[seen])
    third = np.array([crowd.there[2] for crowd in longer])
    assert np.flatnonzero(third)[[0, -1]] * DT == pytest.approx((0.8, 5.2))
    at = [crowd.position[2] for crowd in longer]
    # 1 m/s, from (3, 4) after 2 s to (3, 2) after 4 s.
    np.testing.assert_allclose(at[round(1.0 / DT)], [3.0, 5.0], atol=1e-9)
    np.testing.assert_allclose(at[round(5.1 / DT)], [3.0, 0.9], atol=1e-9)


def test_who_walks_on_keeps_the_mean_pace_of_a_second_and_who_is_seen_once_stays(tmp_path):
    # 1 m/s, but for a last step of 0.4 m in 0.1 s; another is seen once
    rows = [(k, 1, 0.1 * k, 0.0) for k in range(20)] + [(20, 1, 2.3, 0.0), (5, 2, 9.0, 9.0)]
    file = tmp_path / "ends.txt"
    file.write_text("".join(f"{f} {who} {x} {y}\n" for f, who, x, y in rows))
    film = read_trajectories(file, step=0.1)
    longer = film.walking_on(2.0)
    assert longer.begin.tolist() == pytest.approx([-2.0, 0.5])
    assert longer.position[longer.first[1] - 1] == pytest.approx([2.3 + 2.0 * 1.3, 0.0])
    assert len(longer.time) == len(film.time) + 40
    assert film.walking_on(0.0) is film


def test_velocities_are_those_of_the_way_and_who_comes_faces_it(film):
    crowds = replayed(film)
    for before, after in itertools.pairwise(crowds[45:76]):
        mean = (after.position - before.position)[:3] / DT
        both = 0.5 * (after.velocity + before.velocity)[:3]
        np.testing.assert_allclose(mean, both, atol=0.01)
    appeared = next(crowd for crowd in crowds if crowd.there[2])
    assert appeared.heading[2] == pytest.approx(-np.pi / 2.0)


def test_a_film_is_laid_where_and_when_it_is_asked_for(film):
    plain = replayed(film, seconds=7.0)
    moved = replayed(film, seconds=5.0, begin=2.0, at=(3.0, -1.0), angle_deg=90.0)
    X = np.array([3.0, -1.0, np.pi / 2.0])
    for k in range(0, 100, 7):
        there = plain[k + 40].there
        assert (moved[k].there == there).all()
        expected = transform(X, plain[k + 40].position[there])
        np.testing.assert_allclose(moved[k].position[there], expected, atol=1e-9)


def test_who_comes_after_the_ride_is_left_out(film):
    assert len(replayed(film, begin=0.0).pop().radius) == 4
    model = Replay(Replay.Parameters(file=str(film), seconds=1.0))
    assert len(prepare_crowd(model, nobody()).radius) == 3


def test_groups_are_the_films_and_nobody_sees_the_chair(film):
    crowd = replayed(film)[0]
    assert crowd.group.tolist() == [0, 0, -1, -1]
    assert not crowd.sees_robot.any()


def test_others_walk_among_the_filmed_and_avoid_those_who_are_there(film):
    crowds = replayed(film, walker())
    assert all(identical_film(a, b) for a, b in zip(crowds, replayed(film), strict=True))
    apart = [np.hypot(*(c.position[1:][c.there[1:]] - c.position[0]).T).min() for c in crowds]
    assert min(apart) > 0.45  # two bodies of 0.25 m; only one of them gives way
    assert crowds[-1].position[0, 0] < -3.0
    alone = replayed("", walker())
    assert alone[-1].position[0, 1] == pytest.approx(0.0)


def identical_film(crowd, film):
    return np.array_equal(crowd.position[1:][film.there], film.position[film.there])


def test_who_is_not_there_is_neither_told_nor_touched_nor_measured(film):
    """The chair stands where the third comes to later, and where the fourth was missed."""
    settings = [
        f"people.model.file={film}",
        "people.model.at=[10, 10]",
        "people.model.walk_on=0",
        "tracker=given",
    ]
    stage = build_scenario(load_scenario("filmed", ["start=[13, 13, 0]", *settings]), 0)
    assert not stage.world.crowd.sees_robot.any()
    world = World(stage.world, 0)
    told = []
    for _ in range(120):
        truth, there = world.truth, world.truth.crowd.there
        assert (np.isfinite(truth.gap_people) == there).all()
        assert truth.gap_people[there].max() < 20.0
        assert not (truth.hit_moving | truth.hit_standing)[~there].any()
        told.append(world.observe().people.id.tolist())
        assert told[-1] == np.flatnonzero(there).tolist()
        world.advance(Decision(twist=np.zeros(3)))
    assert [0, 1, 3] in told
    assert [0, 1, 2] in told
    assert world.truth.gap_people[2] == np.inf


def test_nobody_comes_where_nobody_is_wanted(film):
    settings = [f"people.model.file={film}", "people.count=0"]
    assert len(build_scenario(load_scenario("filmed", settings), 0).world.crowd.radius) == 0


def test_a_film_beside_the_scenario_is_found(film, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "floor: plaza\nstart: [3, 3]\ngoal: [9, 3]\n"
        f"people: {{model: {{use: replay, file: {film.name}}}}}\n"
    )
    assert len(build_scenario(load_scenario(file), 0).world.crowd.radius) == 4


def test_a_file_that_is_no_film_is_refused_by_name(tmp_path):
    for name in ("absent.txt", "absent.npz"):
        with pytest.raises(RecordingError, match=name):
            replayed(tmp_path / name)
    states = np.zeros((2, 5, 3, 4))
    np.savez(tmp_path / "cases.npz", pos_vel=states)
    with pytest.raises(RecordingError, match="no case 2"):
        replayed(tmp_path / "cases.npz", case=2)
    assert len(replayed(tmp_path / "cases.npz", case=1)[0].radius) == 3


@pytest.mark.data
@pytest.mark.parametrize("name", ["zara01_obsmat.txt", "eth_obsmat.txt"])
def test_recorded_crowds_are_reproduced_at_their_frames(name):
    root = os.environ.get("COHELM_DATA")
    if not root or not (Path(root) / "pedestrians" / name).is_file():
        pytest.skip("COHELM_DATA has no pedestrians")
    walks = read_trajectories(Path(root) / "pedestrians" / name)
    begin = float(walks.instants[100])
    crowds = replayed(f"pedestrians/{name}", seconds=12.0, begin=begin)
    number = crowds[0].memory[:, 0].astype(int)
    assert (number == np.arange(len(number))).all()
    for k in range(0, len(crowds), 8):
        ids, noted, _ = walks.at(begin + k * DT)
        there = crowds[k].there
        assert there.sum() == len(ids)
        np.testing.assert_allclose(crowds[k].position[there], noted, atol=1e-6)


def came(file, chair, **changes):
    """When the one comes who walks from (3, 4) at 2 s to (3, 2) at 4 s; NaN: never."""
    model = Replay(Replay.Parameters(file=str(file), **changes))
    crowd = prepare_crowd(model, nobody())
    for k in range(160):
        crowd = model.step(crowd, scene(k * DT, chair), DT, np.random.default_rng(0))
        if crowd.there[2]:
            return (k + 1) * DT
        assert crowd.position[2, 0] > 1e5
        assert not crowd.velocity[2].any()
    return np.nan


def test_who_would_come_upon_the_chair_comes_once_it_is_far_enough(film):
    chair = (3.0, 4.5)  # the disc's radius is 0.5 m, the body's 0.25 m
    assert came(film, chair) == pytest.approx(2.0)
    assert came(film, (3.0, 6.0), clear=1.2) == pytest.approx(2.0)  # gap 1.25 m at once
    # 1 m/s away: the gap is 0.75 m where 4.5 − y = 1.5, that is at 3 s
    assert came(film, chair, clear=0.75) == pytest.approx(3.0, abs=DT + 1e-9)
    assert np.isnan(came(film, chair, clear=3.0))


def test_who_is_there_stays_however_near_the_chair_comes(film):
    model = Replay(Replay.Parameters(file=str(film), clear=2.0))
    crowd = prepare_crowd(model, nobody())
    for k in range(70):  # far away till they are there, then in their midst
        chair = (1e4, 1e4) if k < 45 else tuple(crowd.position[2])
        crowd = model.step(crowd, scene(k * DT, chair), DT, np.random.default_rng(0))
    assert crowd.there[:3].all()


def test_a_replay_goes_on_from_any_step(film):
    """The model holds nothing: a crowd and a time are enough."""
    crowds = replayed(film)
    model = Replay(Replay.Parameters(file=str(film)))
    again = model.step(crowds[60], scene(60 * DT), DT, np.random.default_rng(5))
    for field in dataclasses.fields(again):
        a, b = getattr(again, field.name), getattr(crowds[61], field.name)
        np.testing.assert_array_equal(a, b)


@pytest.mark.data
def test_crowdnavs_people_are_reproduced_at_their_steps():
    name = "crowdnav/crowdnav_replay_circle_crossing_5.npz"
    root = os.environ.get("COHELM_DATA")
    if not root or not (Path(root) / name).is_file():
        pytest.skip("COHELM_DATA has no recorded people of CrowdNav")
    states = read_cases(Path(root) / name)[7]
    crowds = replayed(name, case=7, seconds=10.0)
    assert len(crowds[0].radius) == 5
    for k in range(41):
        np.testing.assert_allclose(crowds[5 * k].position, states[k, :, :2], atol=1e-9)


def test_unit_and_step_of_a_film_are_parameters(tmp_path):
    rows = [f"1 {n} {1.2 * n / 25.0:.4f} 2.0 1.7" for n in range(100)]
    (tmp_path / "walk.txt").write_text("\n".join(rows))
    given = Replay.Parameters(file=str(tmp_path / "walk.txt"), unit="m", step=0.04)
    assert Replay(given)._film().velocity[:, 0] == pytest.approx(1.2, abs=1e-3)
