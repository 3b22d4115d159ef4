import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from cohelm.evaluation import Outcome, measure, pedestrian_delay, pedestrian_deviation, run, timing
from cohelm.evaluation.episode.counterfactual import (
    Counterfactual,
    counterfactual,
    simulate_without_robot,
)
from cohelm.evaluation.metrics import MEASURES, measure_info, measure_table, path_error
from cohelm.evaluation.metrics.people import group_depth, person_depth
from cohelm.messages import Path as Route
from cohelm.messages import WishReport
from cohelm.scenarios import load_scenario


def along_x(*x):
    """Poses (k, 3) on the x axis."""
    return [[each, 0.0, 0.0] for each in x]


def route(*points):
    points = np.array(points, dtype=float)
    return Route(
        points=points,
        length=10.0,
        cost=10.0,
        method="made",
        wishes=WishReport(closest=np.empty(0)),
        without_wishes=points,
    )


def test_time_and_length_end_at_the_first_entry_into_the_goal(made_ride):
    # 4 + 5.9 m driven to the entry at 9.9, then 0.1 m to the goal; what follows does not count
    ride = made_ride(along_x(0.0, 4.0, 9.9, 10.1, 9.9))
    assert measure(ride)["time"] == pytest.approx(1.0)  # two steps of 0.5 s
    assert measure(ride)["path_length"] == pytest.approx(10.0)


def test_a_goal_never_entered_has_no_time_and_the_length_that_was_driven(made_ride):
    ride = made_ride(along_x(0.0, 4.0, 9.0), outcome=Outcome.TIMEOUT)
    assert math.isnan(measure(ride)["time"])
    assert measure(ride)["path_length"] == pytest.approx(9.0)
    assert measure(ride)["success"] == 0.0


def test_distances_are_clipped_at_contact_and_averaged_over_time(made_ride):
    people = np.zeros((3, 2, 4))
    gaps = [[3.0, 1.0], [2.5, -0.2], [4.0, 2.0]]  # nearest: 1, 0, 2
    values = measure(made_ride(along_x(0, 1, 2), people=people, gap_people=gaps))
    assert values["min_distance"] == 0.0
    assert values["mean_distance"] == pytest.approx(1.0)
    assert values["encounters"] == 1  # the first stays at 2.5 m or more


def test_without_people_distances_have_no_meaning(made_ride):
    values = measure(made_ride(along_x(0, 1, 2)))
    assert math.isnan(values["min_distance"])
    assert math.isnan(values["time_to_collision"])
    assert values["encounters"] == 0
    assert values["social_space_intrusion"] == 0.0


def test_zones_share_the_time(made_ride):
    people = np.zeros((4, 1, 4))
    gaps = [[0.2], [0.45], [1.2], [3.6]]  # intimate, personal, social, none of them
    values = measure(made_ride(along_x(0, 1, 2, 3), people=people, gap_people=gaps))
    assert values["proxemics_intimate"] == 0.25
    assert values["proxemics_personal"] == 0.25
    assert values["proxemics_social"] == 0.25


def test_contacts_are_counted_by_who_moved(made_ride):
    people = np.zeros((4, 3, 4))
    moving = np.zeros((4, 3), dtype=bool)
    standing = np.zeros((4, 3), dtype=bool)
    moving[1, 0] = standing[2, 0] = True  # counted once, as a collision
    standing[1:3, 1] = True  # two ticks of one contact
    wall = [False, True, True, False]  # one contact of two ticks
    values = measure(
        made_ride(
            along_x(0, 1, 2, 3),
            people=people,
            hit_moving=moving,
            hit_standing=standing,
            hit_wall=wall,
        )
    )
    assert values["collisions_person"] == 1
    assert values["standing_contacts"] == 1
    assert values["collisions_wall"] == 1


def test_variances_and_heading(made_ride):
    twist = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, -1.0]])  # var v = ¼, var ω = 1
    poses = [[0, 0, 3.0], [1, 0, -3.0]]  # the short way round: 2π − 6
    values = measure(made_ride(poses, twist=twist))
    assert values["linear_velocity_variance"] == pytest.approx(0.25)
    assert values["angular_velocity_variance"] == pytest.approx(1.0)
    assert values["heading_change"] == pytest.approx(2 * math.pi - 6.0)


def test_acceleration_and_jerk_are_divided_by_the_step(made_ride):
    twist = np.zeros((4, 3))
    twist[:, 0] = [0.0, 0.5, 0.5, 0.0]  # a = 1, 0, −1; jerk = −2, −2
    values = measure(made_ride(along_x(0, 1, 2, 3), twist=twist))
    assert values["acceleration_max"] == pytest.approx(1.0)
    assert values["acceleration_rms"] == pytest.approx(math.sqrt(2.0 / 3.0))
    assert values["jerk_max"] == pytest.approx(2.0)
    assert values["jerk_rms"] == pytest.approx(2.0)


def test_turning_on_the_spot_is_not_stalling_and_neither_is_standing_at_the_goal(made_ride):
    twist = np.zeros((4, 3))
    twist[1, 2] = 0.3  # turns
    ride = made_ride(along_x(0, 0, 5, 10), twist=twist)
    assert measure(ride)["stalled_time"] == pytest.approx(1.0)  # the first and the third tick


def test_time_to_collision_with_constant_velocities(made_ride):
    # The square's one disc has radius √½; the person's centre is 5 m ahead and closes at 2 m/s:
    # (5 − 0.7071 − 0.25) / 2
    people = [[[5.0, 0.0, -1.0, 0.0]]]
    ride = made_ride(along_x(0.0), people=people, twist=[[1.0, 0.0, 0.0]])
    assert len(ride.robot.discs) >= 1
    reach = max(x + r for x, _, r in ride.robot.discs)
    assert measure(ride)["time_to_collision"] == pytest.approx((5.0 - reach - 0.25) / 2.0)


def test_people_who_walk_away_never_collide(made_ride):
    ride = made_ride(along_x(0.0), people=[[[5.0, 0.0, 1.0, 0.0]]])
    assert math.isnan(measure(ride)["time_to_collision"])


def test_intrusion_is_the_persons_gaussian_at_the_chair(made_ride):
    # |v| = 1: σ_h = 2 ahead, so 2 m ahead of the person the Gaussian is exp(−4/8) = 0.6065 > ½;
    # behind, σ_r = 1: exp(−4/2) = 0.1353.  0.5 s each.
    people = [[[2.0, 0.0, -1.0, 0.0]], [[-2.0, 0.0, -1.0, 0.0]]]
    heading = np.full((2, 1), math.pi)
    values = measure(made_ride(along_x(0, 0), people=people, people_heading=heading))
    expected = 0.5 * (math.exp(-0.5) + math.exp(-2.0))
    assert values["social_space_intrusion"] == pytest.approx(expected)
    assert values["social_space_intrusion_share"] == 0.5


def test_spl_compares_with_the_route_without_wishes(made_ride):
    poses = [[0, 0, 0], [5, 5, 0], [10, 0, 0]]  # 10√2 m for a route of 10 m
    ride = made_ride(poses, path=route([0, 0], [10, 0]))
    assert measure(ride)["spl"] == pytest.approx(1.0 / math.sqrt(2.0))
    lost = made_ride(poses, path=route([0, 0], [10, 0]), outcome=Outcome.TIMEOUT)
    assert measure(lost)["spl"] == 0.0


def test_path_error_runs_over_arc_length():
    # half of the length at distance 1, the climb between 0 and 1 is vertical: (½·1 + 5·1)/11, as
    # 5 m at 0, 1 m that climbs (mean ½), 5 m at 1
    path = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 1.0], [10.0, 1.0]])
    mean, hausdorff = path_error(path, np.array([[0.0, 0.0], [10.0, 0.0]]))
    assert mean == pytest.approx(5.5 / 11.0, abs=1e-3)
    assert hausdorff == pytest.approx(1.0)


def test_hausdorff_looks_both_ways():
    short, long = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.0], [4.0, 0.0]])
    assert path_error(short, long)[0] == pytest.approx(0.0)
    assert path_error(short, long)[1] == pytest.approx(3.0)


def test_preference_distance_is_the_worst_of_the_wishes(made_ride):
    ride = made_ride(along_x(0, 10), prefer=[[5.0, 1.0], [5.0, -2.0]])
    assert measure(ride)["preference_distance"] == pytest.approx(2.0)
    assert math.isnan(measure(made_ride(along_x(0, 10)))["preference_distance"])


def test_agreement_of_commands(made_ride):
    # limits 2 m/s and 1 rad/s: (1, 0) and (0, 1) are at right angles, (1, 0) and (½, 0) agree
    asked = [[2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    command = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    values = measure(made_ride(along_x(0, 1, 2), requested=asked, command=command))
    assert values["agreement"] == pytest.approx(0.5)  # (0 + 1)/2; the centred stick does not count
    assert values["disagreement"] == pytest.approx((math.sqrt(2.0) + 0.5) / 2.0)
    assert values["intervention_share"] == 1.0
    assert values["conflict_share"] == 0.0


def test_fighting_is_turning_opposite_ways(made_ride):
    asked = [[0.0, 0.0, 0.5], [0.0, 0.0, 0.5]]
    command = [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]
    assert (
        measure(made_ride(along_x(0, 1), requested=asked, command=command))["conflict_share"] == 0.5
    )


def test_effort_and_reversals_of_the_stick(made_ride):
    # 0 → 1 → −1 → −1 forward: 1 + 2 deflections, one reversal in four ticks of 0.5 s: 30 a minute
    stick = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]]
    values = measure(made_ride(along_x(0, 1, 2, 3), stick=stick))
    assert values["rider_effort"] == pytest.approx(3.0)
    assert values["rider_reversals"] == pytest.approx(30.0)


def test_without_a_device_the_riders_measures_have_no_meaning(made_ride):
    values = measure(made_ride(along_x(0, 1)))
    for name in ("agreement", "disagreement", "conflict_share", "rider_effort", "rider_reversals"):
        assert math.isnan(values[name])


def test_a_group_of_one_place_is_as_deep_as_a_person(made_ride):
    """The hull of the contours of people at one place with one heading is each one's contour."""
    person = np.array([1.0, 0.3, 0.8, 0.0])
    ride = made_ride(along_x(-2, 0, 0.9, 2, 4), people=np.tile(person, (5, 2, 1)))
    them = (ride.pose[:, :2], ride.people, ride.people_heading)
    assert group_depth(*them) == pytest.approx(person_depth(*them).max(axis=1), abs=2e-3)


def test_between_two_who_talk_is_inside_their_space():
    """Both stand 2 m apart: σ_h = 0.5 m ahead, so that either's depth half way is e⁻².

    Across the line between them both reach s σ_s √2 = s √2/3 m: half way the depth is 1, and y
    beside that s = 3y/√2, so that it is exp(−4.5 y²).
    """
    facing = np.zeros((3, 2, 4))
    facing[:, :, 0] = -1.0, 1.0
    heading = np.tile([0.0, np.pi], (3, 1))
    at = np.array([[0.0, 0.0], [0.0, 0.5], [0.0, 9.0]])
    depth = group_depth(at, facing, heading)
    assert depth[:2] == pytest.approx([1.0, np.exp(-4.5 * 0.25)])
    assert depth[2] < 1e-12
    assert (depth >= person_depth(at, facing, heading).max(axis=1)).all()


def test_a_group_of_whom_one_is_there_is_none(made_ride):
    one = np.zeros((2, 2, 4))
    one[:, 1] = np.nan
    assert group_depth(np.zeros((2, 2)), one, np.zeros((2, 2))).max() == 0.0
    values = measure(made_ride(along_x(0, 1), people=one))
    assert math.isnan(values["group_space_intrusion"])  # nobody said that there are groups
    assert math.isnan(values["pedestrian_delay"])


@pytest.mark.slow
def test_people_without_the_chair_are_those_whom_nobody_sees():
    """Blind people walk as if nobody were there, whatever the chair does."""
    blind = run(load_scenario("crossing", ["people.see_robot=false", "time_limit=6"]), 3)
    assert counterfactual(blind) is None
    walked = simulate_without_robot(blind.setup, blind.seed, len(blind.time))
    assert np.array_equal(walked.people, blind.people, equal_nan=True)
    assert np.array_equal(walked.people_target, blind.people_target)
    seen = run(load_scenario("crossing", ["time_limit=6"]), 3)
    assert np.array_equal(counterfactual(seen).people[0], seen.people[0])
    assert measure(seen)["pedestrian_deviation"] > 0.01


@pytest.mark.slow
def test_a_standing_group_has_a_space_of_its_own():
    values = measure(run(load_scenario("joining-group", ["time_limit=8"]), 0))
    assert values["group_space_intrusion"] >= 0.0
    assert 0.0 <= values["group_space_intrusion_share"] <= 1.0


def test_deviation_and_delay_against_the_twin_without_the_robot(made_ride):
    with_robot = made_ride(
        along_x(0, 1, 2),
        people=np.zeros((3, 1, 4)),
        people_target=[[0], [0], [1]],  # passes the way-point one step later
    )
    moved = np.zeros((4, 1, 4))
    moved[:, :, 0] = 2.0
    without = Counterfactual(people=moved, people_target=[[0], [1], [1], [1]])
    assert pedestrian_deviation(with_robot, without) == pytest.approx(2.0)
    assert pedestrian_delay(with_robot, without) == pytest.approx(0.5)
    blind = dataclasses.replace(with_robot, people_see=[False])
    assert math.isnan(pedestrian_delay(blind, without))
    assert math.isnan(pedestrian_deviation(blind, without))


def test_timing_gives_median_tail_and_worst_and_the_first_apart(made_ride):
    ticks = np.concatenate([[10.0], np.linspace(0.0, 1.0, 101)])
    assert timing(made_ride(along_x(0), durations={"tick": ticks}))["tick"] == {
        "median": pytest.approx(0.5), "p99": pytest.approx(0.99), "max": 1.0, "first": 10.0,
    }  # fmt: skip


def test_one_tick_is_all_there_is(made_ride):
    found = timing(made_ride(along_x(0), durations={"tick": np.array([0.5])}))["tick"]
    assert set(found.values()) == {0.5}


def test_the_document_of_measures_agrees_with_their_table():
    page = Path(__file__).parents[3] / "docs" / "measures.md"
    rows = [
        [cell.strip() for cell in line.strip("|\n").split("|")]
        for line in page.read_text(encoding="utf-8").splitlines()
        if line.startswith("| `")
    ]
    directions = {"higher": 1, "lower": -1, "": 0}
    documented = {
        name.strip("`"): (label, unit, directions[better]) for name, label, unit, better, _ in rows
    }
    table = {
        each["name"]: (each["label"], each["unit"], each["better"]) for each in measure_table()
    }
    assert documented == table


def test_a_measure_is_shown_with_its_unit():
    assert MEASURES["time"].heading == "time to goal, s"
    assert MEASURES["authority"].text(0.123) == "12.3"  # percent
    assert MEASURES["reached"].text(1.0) == "100"
    assert MEASURES["min_distance"].text(-0.001) == "0.00"
    assert MEASURES["min_distance"].text(math.nan) == "–"
    assert measure_info("people.count").heading == "people.count"
