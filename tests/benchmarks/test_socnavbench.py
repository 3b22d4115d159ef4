"""SocNavBench's episodes: reading them, its measures, and the report."""

import math

import numpy as np
import pytest
from tests.made_rides import made_ride

from cohelm.benchmarks.bench import Result
from cohelm.benchmarks.external import socnavbench
from cohelm.benchmarks.rides import report
from cohelm.errors import ConfigError, RecordingError
from cohelm.evaluation.sweeps import ride_row
from cohelm.recordings.pedestrians.socnavbench import episode_names, read_episode

EPISODE = """[episodes_params]
tests=['t_one'] ; which to ride
[t_one]
map_name=Street
pedestrian_datasets=["street"] ; who walks
datasets_start_t = [0]
ped_ranges=[(1, -1)]
agents_start=[]
robot_start_goal=[[2, 3, 1.57], [2, 9, 0]] # x, y, theta
max_time=20
"""
DATASET = """[street]
file_name=street/world.csv
fps=10
offset=[1, 20, 0]
swapxy=True
flipxn=True
flipyn=False
"""


@pytest.fixture
def folder(tmp_path):
    """Person 1, and person 2 who walks along x at 1 m/s, y = 4, from frame 30 on."""
    frames = [10, 11, *range(30, 130)]
    who = [1, 1, *[2] * 100]
    x = [0.0, 0.1, *(0.1 * np.arange(100) + 5.0)]
    rows = (frames, who, [4.0] * 102, x)
    (tmp_path / "street.csv").write_text("\n".join(",".join(map(str, row)) for row in rows))
    (tmp_path / "dataset_params.ini").write_text(DATASET)
    (tmp_path / "episodes.ini").write_text(EPISODE)
    return tmp_path


def test_people_are_moved_to_the_map_and_time_begins_with_the_first_of_them(folder):
    file = folder / "episodes.ini"
    assert episode_names(file) == ("t_one",)
    people, section = read_episode(file, "t_one")
    assert section.robot_start_goal == ((2, 3, 1.57), (2, 9, 0))
    who, position, velocity = people.at(2.0)
    assert who.tolist() == [2]
    # y before −x, then the offset: (4 + 1, −7 + 20); 1 m/s along x is −1 m/s along y
    np.testing.assert_allclose(position, [[5.0, 13.0]], atol=1e-9)
    np.testing.assert_allclose(velocity, [[0.0, -1.0]], atol=1e-9)
    (folder / "episodes.ini").write_text(EPISODE.replace("(1, -1)", "(0, 1)"))
    assert read_episode(file, "t_one")[0].id.tolist() == [1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("max_time=20", "", r"episodes\.ini: t_one\.max_time: "),
        ("max_time=20", "max_time=soon", r"episodes\.ini: t_one\.max_time: "),
        ("[[2, 3, 1.57], ", "[[2, 3, 1.57] ", r"episodes\.ini: t_one\.robot_start_goal"),
        ("[(1, -1)]", "[(1, -1), (2, -1)]", r"episodes\.ini: t_one: .*differ in length"),
        ("[(1, -1)]", "[(7, -1)]", r"episodes\.ini: t_one\.ped_ranges: selects no person"),
        ("agents_start=[]", "agents_start=[[1, 2, 3]]", r"episodes\.ini: t_one\.agents_start"),
        ('["street"]', '["stret"]', r"dataset_params\.ini: no section is called 'stret'.*street"),
        ("[t_one]", "[t_one", r"episodes\.ini: "),
        ("max_time=20", "max_time=20\nmax_time=30", r"episodes\.ini: .*max_time"),
    ],
)
def test_a_wrong_episode_is_one_line_with_file_section_and_key(folder, old, new, message):
    file = folder / "episodes.ini"
    file.write_text(EPISODE.replace(old, new))
    with pytest.raises(ConfigError, match=message) as raised:
        socnavbench.create(planners="dwa", file=str(file))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2\n1,1\n3,4", "needs four rows"),
        ("1,2\n1,1\n3,4\n5", "is not a table"),
        ("1,2\n1,1\n3,4\n5,x", "is not a table"),
        ("1,1\n2,2\n3,4\n5,6", "person 2 is in frame 1 twice"),
        ("1,2\n1,1\n3,nan\n5,6", "finite numbers"),
    ],
)
def test_a_damaged_recording_is_refused(folder, text, message):
    (folder / "street.csv").write_text(text)
    with pytest.raises(RecordingError, match=message):
        read_episode(folder / "episodes.ini", "t_one")


def test_a_missing_recording_names_where_it_was_looked_for(folder):
    (folder / "street.csv").unlink()
    with pytest.raises(ConfigError, match=r"street\.file_name: .*world\.csv nor street\.csv"):
        read_episode(folder / "episodes.ini", "t_one")


def test_measures_of_a_straight_ride_past_a_person():
    # 10 m along x in steps of 1 m; a person stands 2 m beside the middle. made_ride: square of 1 m
    pose = np.column_stack([np.arange(11.0), np.zeros((11, 2))])
    people = np.tile([5.0, 2.0, 0.0, 0.0], (11, 1, 1))
    twist = np.tile([2.0, 0.0, 0.0], (11, 1))
    ride = made_ride(pose, people=people, twist=twist)
    found = socnavbench.socnavbench_columns(ride)
    assert found["path_length_ratio"] == pytest.approx(1.0)
    assert found["path_irregularity"] == pytest.approx(0.0)
    assert found["goal_traversal_ratio"] == pytest.approx(0.0)
    assert found["motion_energy"] == pytest.approx(11 * 0.5 * 4.0)
    away = np.hypot(np.arange(11.0) - 5.0, 2.0)
    assert found["closest_pedestrian"] == pytest.approx(away.mean())
    # the closing speed at x < 5 is 2·(5 − x)/d; afterwards nobody comes nearer: 10 s
    ahead = 5.0 - np.arange(5.0)
    times = (away[:5] - math.hypot(0.5, 0.5)) * away[:5] / (2.0 * ahead)
    assert found["socnavbench_ttc"] == pytest.approx((times.sum() + 6 * 10.0) / 11)
    # turned by 90° and moved, all is the same: the measure does not depend on the origin
    turned = np.column_stack([np.full(11, 7.0), 3.0 + np.arange(11.0), np.full(11, math.pi / 2)])
    moved = np.tile([5.0, 8.0, 0.0, 0.0], (11, 1, 1))
    again = made_ride(turned, people=moved, twist=twist, goal=[7.0, 13.0])
    assert socnavbench.socnavbench_columns(again) == pytest.approx(found, nan_ok=True)


def test_an_episode_is_ridden_with_its_measures(folder):
    bench = socnavbench.create(planners="dwa", file=str(folder / "episodes.ini"))
    ((task,),) = bench.tasks(range(1))
    scenario = task.load(("time_limit=2",))
    assert (scenario.start[2], scenario.people.see_robot) == (pytest.approx(89.95, abs=0.01), False)
    np.testing.assert_allclose(np.subtract(scenario.goal, scenario.start[:2]), [0.0, 6.0])
    short = socnavbench.RideTask(
        task.columns, task.scenario, (*task.settings, "time_limit=2"), task.seed
    )
    row = ride_row(short, empty_floor=False, more=socnavbench.socnavbench_columns).row
    assert row["error"] == ""
    assert row["outcome"] == "timeout"
    assert 0.8 < row["goal_traversal_ratio"] < 1.0
    assert math.isnan(row["path_length_ratio"])


def test_the_report_counts_arrivals_and_collisions(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "write_results", lambda *_, **__: ())
    rows = [
        {
            "scene": scene, "planner": "ss_mpc_dcbf", "seed": 0, "outcome": outcome,
            "collisions_person": outcome == "collision", "people_source": "tracker",
            "error": "", "replay": "",
        }
        for scene, outcome in (("a", "reached"), ("b", "collision"), ("c", "collision"))
    ]  # fmt: skip
    found = socnavbench.episodes_report([Result(row) for row in rows], tmp_path)
    assert [v["found"] for v in found.summary["verdicts"]] == ["1 of 3", "2 of 3"]
