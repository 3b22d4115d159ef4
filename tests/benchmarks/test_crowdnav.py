"""The rules of CrowdNav, held to figures that others measured and to hand-made cases."""

import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.external import crowdnav as bench
from cohelm.benchmarks.external.crowdnav import crowdnav_report, summed
from cohelm.errors import ConfigError
from cohelm.evaluation.external import crowdnav
from cohelm.evaluation.external.crowdnav import (
    DT,
    drawn_ends,
    moved,
    own_case,
    recorded,
    run,
    swept_gap,
    walked,
)
from cohelm.evaluation.external.crowdnav_drivers import (
    DriverSetup,
    PlannerDriver,
    disc_robot,
    orca,
    straight,
)

NOBODY = np.zeros((1, 0, 4))


@pytest.fixture(scope="session")
def people():
    folder = os.environ.get("COHELM_DATA")
    if not folder or not (Path(folder) / crowdnav.REPLAY).exists():
        pytest.skip("COHELM_DATA has no recorded people of CrowdNav")
    return recorded()


def standing(*places):
    return np.array([[[x, y, 0.0, 0.0] for x, y in places]])


def test_straight_ahead_takes_31_steps():
    """7.7 m to within 0.3 m of the goal at 1 m/s: 30.8 steps of a quarter of a second."""
    outcome = run(NOBODY, straight("holonomic"), "holonomic")
    assert (outcome.end, outcome.steps, outcome.time) == ("success", 31, 7.75)
    assert outcome.path == pytest.approx(7.75)
    assert outcome.danger == 0


def test_a_unicycle_turns_first_and_then_moves_straight():
    velocity, heading = moved(0.0, np.array([2.0, 3.0]), "unicycle")
    assert heading == DT  # no more than 1 rad/s
    assert velocity == pytest.approx([np.cos(DT), np.sin(DT)])  # nor than 1 m/s
    velocity, _ = moved(0.0, np.array([-1.0, 0.0]), "unicycle")
    assert velocity == pytest.approx([0.0, 0.0])  # nor backwards


def test_a_gap_is_swept_within_the_step_with_the_velocity_of_before():
    """A person who crosses at 4 m/s passes the robot between two moments: both ends lie apart."""
    crossing = np.array([[-0.5, 0.0, 4.0, 0.0]])
    assert swept_gap(crossing, np.zeros(2), np.zeros(2)) == pytest.approx(-0.6)
    assert swept_gap(np.zeros((0, 4)), np.zeros(2), np.zeros(2)) == np.inf


def test_time_comes_before_collision_and_collision_before_arrival():
    hit = run(standing((0.0, -3.0)), straight("holonomic"), "holonomic")
    assert hit.end == "collision"
    assert hit.time == 0.5  # 0.4 m of room and 0.25 m a step
    at_goal = run(standing((0.0, 4.4)), straight("holonomic"), "holonomic")
    assert at_goal.end == "success"  # 0.3 m before the goal its centre is 0.7 m away
    beyond = run(standing((0.0, 4.25)), straight("holonomic"), "holonomic")
    assert beyond.end == "collision"  # the step that arrives also touches
    idle = run(NOBODY, lambda seen: np.zeros(2), "holonomic")
    assert (idle.end, idle.time) == ("timeout", 24.25)  # decided in the step that begins at 24 s


def test_danger_counts_steps_with_a_gap_below_a_fifth_of_a_metre():
    """Past somebody 0.7 m aside, within 0.8 m over ±√(0.8² − 0.7²) = ±0.387 m of the way."""
    outcome = run(standing((0.7, 0.0)), straight("holonomic"), "holonomic")
    assert outcome.least_gap == pytest.approx(0.1)
    # steps [−0.5, −0.25] … [0.25, 0.5] touch ±0.387
    assert outcome.danger == 4


@pytest.mark.data
def test_straight_ahead_is_as_successful_as_was_measured(people):
    outcomes = [run(case, straight("unicycle"), "unicycle") for case in people]
    ends = [outcome.end for outcome in outcomes]
    assert ends.count("success") / len(ends) == pytest.approx(0.026)
    assert ends.count("collision") / len(ends) == pytest.approx(0.974)
    assert {o.time for o in outcomes if o.end == "success"} == {7.75}


@pytest.mark.data
@pytest.mark.slow
def test_orca_is_as_successful_as_was_measured(people):
    rows = [
        {"outcome": o.end, "time": o.time, "path": o.path, "steps": o.steps, "danger": o.danger}
        for o in (run(case, orca(0.0), "holonomic") for case in people)
    ]
    line = summed(rows, "orca", "holonomic")
    assert line.success == pytest.approx(0.426, abs=0.004)
    assert line.collision == pytest.approx(0.568, abs=0.004)
    assert line.time == pytest.approx(10.86, abs=0.02)
    assert line.path == pytest.approx(8.883, abs=0.02)


@pytest.mark.data
def test_our_people_walk_as_the_recorded_ones(people):
    for case in (0, 100):
        walk = walked(people[case, 0], -people[case, 0, :, :2], 41)
        assert np.abs(walk[:, :, :2] - people[case, :41, :, :2]).max() < 0.02


@pytest.mark.parametrize(("layout", "count"), [("circle", 5), ("square", 10)])
def test_own_cases_are_their_seed_and_begin_apart(layout, count):
    case = own_case(layout, count, 3)
    assert case.shape == (101, count, 4)
    assert np.array_equal(case, own_case(layout, count, 3))
    assert not np.array_equal(case, own_case(layout, count, 4))
    starts, goals = drawn_ends(layout, count, np.random.default_rng(0))
    for places, robot in ((starts, crowdnav.START[:2]), (goals, crowdnav.GOAL)):
        every = np.vstack([places, robot])
        apart = np.hypot(*(every[:, None] - every[None]).T)
        assert apart[~np.eye(count + 1, dtype=bool)].min() >= 0.8


def test_planners_roll_the_robot_out_as_it_moves():
    """The unicycle's first step, and the holonomic robot's, heading east."""
    unicycle = disc_robot("unicycle").motion_model.rollout(np.zeros(3), np.array([[0.8, 0.5]]), DT)
    velocity, heading = moved(0.0, np.array([0.8, 0.5]), "unicycle")
    assert unicycle[1] == pytest.approx([*(DT * velocity), heading])
    holonomic = disc_robot("holonomic").motion_model.rollout(
        np.zeros(3), np.array([[0.6, 0.5, 0.0]]), DT
    )
    velocity, heading = moved(0.0, np.array([0.6, 0.5]), "holonomic")
    assert holonomic[1] == pytest.approx([*(DT * velocity), heading])


@pytest.mark.parametrize("model", crowdnav.MODELS)
def test_the_robot_is_one_disc_of_its_radius(model):
    robot = disc_robot(model)
    assert robot.discs.tolist() == [[0.0, 0.0, 0.3]]
    assert robot.capsule.tolist() == [0.0, 0.0, 0.0, 0.0, 0.3]


@pytest.mark.parametrize("model", crowdnav.MODELS)
def test_the_best_arc_passes_who_stands_in_the_way(model):
    driver = PlannerDriver(DriverSetup(planner={"use": "best_arc"}), model)
    outcome = run(standing((0.1, 0.0)), driver, model)
    assert outcome.end == "success"
    assert outcome.least_gap > 0.1
    assert outcome.time < 10.0


def test_what_does_not_exist_is_told():
    for wrong in ({"planner": "teb2"}, {"kinematics": "tracked"}, {"layout": "star"}):
        with pytest.raises(ConfigError):
            bench.create(**wrong)
    with pytest.raises(ConfigError):
        bench.create(planner="best_arc", settings=["planner.sampling.margn=1"]).tasks(range(1))


@pytest.mark.parametrize("caution", [np.nan, np.inf, -5.0, -0.21, 2.1])
@pytest.mark.parametrize("planner", ["best_arc", "straight", "orca"])
def test_people_are_made_wider_within_bounds_only(planner, caution):
    """At −5 m their radius were negative; NaN is no row of a table."""
    with pytest.raises(ConfigError, match="caution"):
        bench.create(planner=planner, layout="circle", caution=[0.0, caution])
    with pytest.raises(ConfigError, match="caution"):
        orca(caution)
    chosen = bench.CrowdNavBench(planner="best_arc", source="circle", cautions=(caution,))
    with pytest.raises(ConfigError, match="caution"):
        chosen.work((caution, "unicycle", 0), Path())


@pytest.mark.parametrize("caution", [-0.2, 2.0])
def test_bounds_of_caution_are_allowed(caution):
    assert bench.create(planner="orca", layout="circle", caution=[caution]).cautions == (caution,)
    assert orca(caution) is not None


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_recording_with_what_is_no_number_is_refused(tmp_path, bad):
    states, file = np.zeros((2, 6, 5, 4)), tmp_path / "people.npz"
    np.savez(file, pos_vel=states)
    assert recorded(file).shape == states.shape
    states[1, 5, 4, 3] = bad
    np.savez(file, pos_vel=states)
    with pytest.raises(ConfigError, match="finite"):
        recorded(file)


def test_a_file_that_is_no_recording_is_refused(tmp_path):
    single, damaged, empty = (tmp_path / name for name in ("a.npy", "b.npz", "c.npz"))
    np.save(single, np.zeros(3))
    damaged.write_bytes(b"PK\x03\x04 and no more")
    np.savez(empty, pos_vel=np.zeros((2, 0, 5, 4)))
    for file in (single, damaged, empty):
        with pytest.raises(ConfigError):
            recorded(file)


def test_no_data_is_said_so(monkeypatch, tmp_path):
    monkeypatch.delenv("COHELM_DATA", raising=False)
    with pytest.raises(ConfigError, match="COHELM_DATA is not set"):
        bench.create().tasks(range(1))
    other = tmp_path / "people.npz"
    np.savez(other, something=np.zeros(3))
    with pytest.raises(ConfigError, match="is not a recording"):
        bench.create(replay=other).tasks(range(1))


def test_a_bench_of_own_cases_has_a_row_for_each(tmp_path):
    chosen = bench.create(planner="straight", layout="circle", people=3, caution=(0.0, 0.1))
    tasks = chosen.tasks(range(2))
    assert len(tasks) == 2 * 2 * 2  # cautions, kinds of robot, cases
    results = [row for task in tasks for row in chosen.work(task, tmp_path)]
    report = chosen.report(results, tmp_path)
    assert (tmp_path / "curve.png").exists()
    assert len(report.summary["lines"]) == 4


def test_orca_drives_no_unicycle():
    with pytest.raises(ConfigError, match="holonomic robot only"):
        bench.create(planner="orca", kinematics="unicycle")
    assert bench.create(planner="orca").models == ("holonomic",)


def _case(case, caution, kinematics="holonomic", outcome="success"):
    return {"case": case, "kinematics": kinematics, "caution": caution, "outcome": outcome,
            "time": 9.0, "path": 8.5, "steps": 36, "danger": 0, "command_ms": 5.0,
            "command_p99_ms": 8.0}  # fmt: skip


def made(rows, folder, *, judged=True):
    return crowdnav_report(rows, "ss_mpc_dcbf", folder, references=True, judged=judged)


def met(report):
    return sum(each["result"] == "met" for each in report.summary["verdicts"])


def test_requirements_apply_to_all_cases_without_caution(tmp_path):
    rows = [_case(k, c) for c in (-0.1, 0.0, 0.1) for k in range(5)]
    rows += [_case(k, -0.1, "unicycle", "collision") for k in range(5)]  # interrupted there
    found = made(rows, tmp_path)
    assert [line[1] for line in found.sheets[0].rows] == ["holonomic"]
    assert met(found) == 4
    assert "5 of the 500 recorded cases: the verdicts are no findings" in found.notes
    assert len(found.summary["lines"]) == 4
    cautious = made(rows[10:15], tmp_path)
    assert met(cautious) == 0
    assert "people +0.1 m wider" in cautious.sheets[0].title
    whole = made([_case(k, 0.0) for k in range(500)], tmp_path)
    assert not any("no findings" in note for note in whole.notes)


def titles(chosen, folder):
    results = [Result(_case(k, 0.0)) for k in range(2)]
    return [sheet.title for sheet in chosen.report(results, folder).sheets]


def test_another_recording_has_no_references(tmp_path):
    file = tmp_path / "other.npz"
    np.savez(file, pos_vel=np.zeros((2, 6, 5, 4)))
    other = titles(bench.create(replay=file), tmp_path)
    assert not any("others" in title or "Claims" in title for title in other)
    assert not any("others" in each for each in titles(bench.create(layout="circle"), tmp_path))


@pytest.mark.data
def test_the_recorded_cases_have_references(people, tmp_path):
    file = tmp_path / "copy.npz"
    np.savez(file, pos_vel=people)
    for chosen in (bench.create(), bench.create(replay=file)):
        assert any("others" in each for each in titles(chosen, tmp_path))
