"""Laws of sampled ways round, and of the score that judges every way."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.control import Motion
from cohelm.control.candidates import Arcs
from cohelm.control.candidates.table import first_arcs, pushes
from cohelm.geometry import transform
from cohelm.maps import distance_field
from cohelm.messages import Groups, RiderProfile
from cohelm.robots import load_robot
from cohelm.social import PersonalSpace
from cohelm.testing.problems import mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, room, straight_on, walkers

ARCS = Arcs()
STEP = 0.16
MIRROR = {2: np.array([1.0, -1.0]), 3: np.array([1.0, -1.0, -1.0])}


def wheels(problem):
    return problem.robot.motion.input(problem.twist)


def ways_of(problem, arcs=ARCS, warm=None):
    return arcs.ways(problem, wheels(problem), warm)


def score_of(problem, inputs, arcs=ARCS):
    return arcs.look(problem, wheels(problem)).score(inputs)


def scene(kinematics="unicycle", **given_):
    robot = load_robot("quantum_q6_edge").model_copy(update={"kinematics": kinematics})
    return local_problem(steps=25, step=STEP, robot=robot, **given_)


def drawn(seed, people, kinematics="unicycle"):
    problem = random_problem(np.random.default_rng(seed), people).problem
    robot = problem.robot.model_copy(update={"kinematics": kinematics})
    return dataclasses.replace(problem, robot=robot)


@pytest.mark.parametrize("others", [0, 2])
def test_a_berth_is_shared_by_all_who_walk_against_the_robot(others):
    """Beside the way: as dear as if the margin grew by what falls to each of those."""
    far = [[-3.0, 5.0 - k, -0.6, 0.0] for k in range(others)]
    problem = scene(people=walkers([[3.0, 0.9, -0.6, 0.0], *far]))
    inputs = np.tile([0.8, 0.0], (25, 1))
    shared = Arcs(Arcs.Parameters(growth=0.04, berth=0.3, greatest=2.0))
    alone = Arcs(Arcs.Parameters(growth=0.04 + 0.3 / (1 + others), greatest=2.0))
    off = Arcs(Arcs.Parameters(growth=0.04, berth=0.0, greatest=2.0))
    cost = score_of(problem, inputs, shared).score
    assert cost == pytest.approx(score_of(problem, inputs, alone).score, abs=1e-9)
    assert cost > score_of(problem, inputs, off).score + 0.01


@pytest.mark.parametrize("table", [first_arcs(640), pushes(80)])
def test_the_tables_are_closed_under_mirroring(table):
    flip = np.array([1.0, -1.0] * 3 + [1.0] * 3)
    rows = {tuple(row + 0.0) for row in table}
    assert {tuple(row * flip + 0.0) for row in table} == rows


@settings(max_examples=8, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([0, 1, 6]),
    st.sampled_from(sorted(["unicycle", "holonomic"])),
)
def test_ways_obey_the_limits_and_are_rollouts_of_their_inputs(seed, people, kinematics):
    problem = drawn(seed, people, kinematics)
    now = wheels(problem)
    low, high, rise, fall = problem.input_bounds()
    ways = ways_of(problem)
    assert len(ways) >= 1
    assert (np.diff(ways.score) >= 0.0).all()
    assert ways.step * ways.inputs.shape[1] >= 6.0 - 1e-9
    for inputs, poses in zip(ways.inputs, ways.poses, strict=True):
        rolled = problem.robot.motion.rollout(problem.pose, inputs, ways.step)
        assert np.abs(rolled - poses).max() < 1e-9
        change = np.diff(np.vstack([now, inputs]), axis=0)
        assert (change <= rise * STEP + 1e-9).all()
        assert (change >= -fall * STEP - 1e-9).all()
        assert (inputs <= np.maximum(high, now) + 1e-9).all()
        assert (inputs >= np.minimum(low, now) - 1e-9).all()
        joint = problem.robot.motion.translating
        speed = np.linalg.norm(inputs[:, :joint], axis=1)
        assert speed.max() <= max(problem.top_speed, np.linalg.norm(now[:joint])) + 1e-9


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_or_mirrored_world_has_turned_or_mirrored_ways(seed, kinematics):
    problem = drawn(seed, 5, kinematics)
    ways = ways_of(problem)
    other = ways_of(turned(problem, np.array([2.0, -1.0, np.pi / 2.0])))
    assert np.abs(other.inputs[0] - ways.inputs[0]).max() < 1e-6
    flipped = ways_of(mirrored(problem))
    assert np.abs(flipped.inputs[0] * MIRROR[len(wheels(problem))] - ways.inputs[0]).max() < 1e-6


def test_the_same_problem_gives_the_same_ways():
    problem = drawn(3, 8)
    assert identical(ways_of(problem), ways_of(problem))


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
def test_ways_keep_their_score_when_they_are_judged_again(kinematics):
    problem = drawn(5, 8, kinematics)
    ways = ways_of(problem)
    again = score_of(problem, ways.inputs)
    np.testing.assert_allclose(again.score, ways.score, rtol=1e-12)
    np.testing.assert_array_equal(again.signature, ways.signature)


def test_the_last_plan_is_among_what_is_judged():
    problem = scene(speed=0.8, people=walkers([[4.0, 0.3, -0.8, 0.0]]))
    first = ways_of(problem)
    warm = Motion(
        step=STEP, poses=first.poses[0], inputs=first.inputs[0], last_input=wheels(problem)
    )
    assert ways_of(problem, warm=warm).score[0] <= first.score[0] + 1e-12


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
def test_alone_at_pace_straight_on_loses_nothing(kinematics):
    ways = ways_of(scene(kinematics, speed=0.8))
    assert ways.score[0] < 0.01
    assert ways.inputs[0, :, 0] == pytest.approx(0.8, abs=0.02)


def test_who_comes_head_on_is_passed_on_either_side():
    problem = scene(speed=0.8, people=walkers([[5.0, 0.05, -0.8, 0.0]]))
    ways = ways_of(problem)
    assert ways.contact[0] == np.inf
    assert {-1, 1} <= set(ways.signature[:, 1])
    # passed on the right, he is seen to the left: the bearing to him turns counter-clockwise
    right = int(np.argmax(ways.signature[:, 1] == 1))
    assert ways.poses[right, :, 1].min() < -0.2


@pytest.mark.parametrize(("side", "sign"), [("right", 1), ("left", -1)])
def test_the_rider_chooses_the_side(side, sign):
    problem = scene(speed=0.8, people=walkers([[5.0, 0.0, -0.8, 0.0]]))
    problem = dataclasses.replace(problem, profile=RiderProfile(passing_side=side))
    assert ways_of(problem).signature[0, 1] == sign


def test_a_future_that_is_less_likely_costs_less_and_a_later_hit_less_than_a_sooner():
    """Straight on at 0.8 m/s into someone who stands: the price is proportional to his weight."""
    alone, straight = scene(speed=0.8), np.tile([0.8, 0.0], (38, 1))

    def price(x, weight):
        problem = scene(speed=0.8, people=walkers([[x, 0.0, 0.0, 0.0]]))
        p = dataclasses.replace(problem.predictions, weight=np.full((1, 1), weight))
        problem = dataclasses.replace(problem, predictions=p)
        return score_of(problem, straight).score[0]

    nobody = score_of(alone, straight).score[0]
    assert price(2.5, 0.5) - nobody == pytest.approx(0.5 * (price(2.5, 1.0) - nobody))
    assert price(2.5, 1.0) > price(3.5, 1.0) > nobody


def test_who_stands_may_be_passed_more_closely_than_who_walks():
    """8 cm beside somebody, where who walks is to be passed at 12 cm and who stands at 5 cm."""
    straight, close = np.tile([0.8, 0.0], (38, 1)), Arcs(Arcs.Parameters(space=0.0, still=0.05))
    same = Arcs(Arcs.Parameters(space=0.0))

    def price(arcs, *people):
        problem = scene(speed=0.8, people=walkers(np.reshape(people, (-1, 4))))
        return score_of(problem, straight, arcs).score[0]

    beside = walkers([[0.0, 0.0, 0.0, 0.0]]).radius[0] + scene().robot.capsule[4] + 0.08
    stands, walks = [2.5, beside, 0.0, 0.0], [2.5, beside, -0.8, 0.0]
    assert price(close, stands) == price(close)
    assert price(same, stands) > price(same)
    assert price(close, walks) == pytest.approx(price(same, walks))
    assert price(close, walks) > price(close)


def test_standing_is_not_free_of_risk():
    stand = np.zeros((38, 2))
    into = scene(people=walkers([[3.0, 0.0, -0.8, 0.0]]))
    past = scene(people=walkers([[3.0, 3.0, -0.8, 0.0]]))
    hit, clear = (score_of(p, stand) for p in (into, past))
    assert hit.score[0] > clear.score[0] + 1.0
    assert np.isfinite(hit.contact[0])
    assert clear.contact[0] == np.inf


def test_somebody_far_away_changes_nothing():
    alone = ways_of(scene(speed=0.6))
    far = ways_of(scene(speed=0.6, people=walkers([[-30.0, 20.0, 0.0, 0.0]])))
    np.testing.assert_array_equal(far.inputs, alone.inputs)
    np.testing.assert_array_equal(far.score, alone.score)


def test_no_way_leads_between_the_members_of_a_group():
    """Two who stand 1.8 m apart: one drives between them only where they do not belong together."""
    people = walkers([[3.0, 0.9, 0.0, 0.0], [3.0, -0.9, 0.0, 0.0]])
    predictions = straight_on(people, 25, STEP)
    together = Groups(id=np.array([1]), member=np.array([0, 0]))

    def between(groups):
        spaces = PersonalSpace().spaces(
            people, groups, predictions, np.zeros(3), RiderProfile(social_distance=0.2)
        )
        problem = dataclasses.replace(scene(speed=0.8, people=people), spaces=spaces)
        poses = ways_of(problem).poses[0]
        return ((np.abs(poses[:, 0] - 3.0) < 0.3) & (np.abs(poses[:, 1]) < 0.9)).any()

    assert between(Groups.alone(2))
    assert not between(together)


def test_a_box_on_the_path_is_passed_on_either_side_without_contact():
    walls = distance_field(room(boxes=[(4.5, 3.7, 5.0, 4.3)]))
    ways = ways_of(scene(pose=(2.0, 4.0, 0.0), speed=0.6, wanted=0.6, walls=walls))
    discs = load_robot("quantum_q6_edge").discs
    for poses, contact in zip(ways.poses, ways.contact, strict=True):
        gap = walls.at(transform(poses[:, None, :], discs[:, :2])) - discs[:, 2]
        assert (gap.min() > 0.0) or np.isfinite(contact)
    assert ways.contact[0] == np.inf
    assert ways.poses[0, -1, 0] > 4.0  # it gets on
    assert {-1, 1} <= set(ways.signature[:, 0])


def test_before_a_wall_that_blocks_the_way_the_best_way_stops():
    walls = distance_field(room(boxes=[(5.0, 0.0, 5.5, 8.0)]))
    ways = ways_of(scene(pose=(2.0, 4.0, 0.0), speed=0.6, wanted=0.6, walls=walls))
    assert ways.contact[0] == np.inf
    assert ways.poses[0, :, 0].max() < 5.0 - 0.5


def test_a_short_way_is_continued_back_to_the_path():
    problem = scene(pose=(0.0, 0.5, 0.3), speed=0.8)
    line = dataclasses.replace(
        problem.reference, poses=scene().reference.poses
    )  # along the x-axis, half a metre to the right
    problem = dataclasses.replace(problem, reference=line)
    found = score_of(problem, np.tile([0.8, 0.0], (3, 1)))
    assert found.inputs.shape[1] == 38
    assert abs(found.poses[0, -1, 1]) < 0.1
