"""Laws of sampled trajectories and of their score."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.control import OptimalControl, Trajectory
from cohelm.control.sampling import Sampling, evaluate, sample
from cohelm.control.sampling.arc_table import arc_table, perturbations
from cohelm.control.stack import Terms
from cohelm.control.terms import Barrier, PersonalSpaceCost
from cohelm.geometry import transform
from cohelm.maps import distance_field
from cohelm.messages import Groups, RiderProfile
from cohelm.robots import load_robot
from cohelm.robots.clearance import Clearance
from cohelm.social import PersonalSpace
from cohelm.testing.problems import mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, room, straight_on, walkers

BUDGET, PLANNED = Sampling(), 24
STEP = 0.16
UNPRICED = Barrier(l1=0.0, l2=0.0)
CLEARANCE_ALONE = Terms(
    personal_space=PersonalSpaceCost(weight=0.0), bodies=UNPRICED, social_space=UNPRICED
)
"""Terms that leave only the clearance to people."""
MIRROR = {2: np.array([1.0, -1.0]), 3: np.array([1.0, -1.0, -1.0])}


def wheels(problem):
    return problem.robot.motion_model.input(problem.twist)


def prepared(problem, terms=None, clearance=None):
    known = len(problem.reference.speeds) - 1
    control = OptimalControl(terms or Terms(), clearance or Clearance())
    return control.prepare(
        problem,
        wheels(problem),
        planned=min(PLANNED, known),
        steps=BUDGET.steps(problem.reference.step, known),
        wall_margin=0.02,
    )


def candidates_of(problem, warm=None):
    return sample(prepared(problem), BUDGET, warm)


def cost_of(problem, inputs, terms=None, clearance=None):
    return evaluate(
        prepared(problem, terms, clearance), np.reshape(inputs, (-1, *inputs.shape[-2:]))
    )


def scene(kinematics="unicycle", **given_):
    robot = load_robot("quantum_q6_edge").model_copy(update={"kinematics": kinematics})
    return local_problem(steps=25, step=STEP, robot=robot, **given_)


def drawn(seed, people, kinematics="unicycle"):
    problem = random_problem(np.random.default_rng(seed), people).problem
    robot = problem.robot.model_copy(update={"kinematics": kinematics})
    return dataclasses.replace(problem, robot=robot)


@pytest.mark.parametrize("others", [0, 2])
def test_the_oncoming_margin_is_shared_by_all_oncoming_people(others):
    """Beside the way: as dear as if the margin grew by what falls to each of those."""
    far = [[-3.0, 5.0 - k, -0.6, 0.0] for k in range(others)]
    problem = scene(people=walkers([[3.0, 0.9, -0.6, 0.0], *far]))
    inputs = np.tile([0.8, 0.0], (25, 1))
    shared = Clearance(growth=0.04, oncoming=0.3, upper=2.0)
    alone = Clearance(growth=0.04 + 0.3 / (1 + others), upper=2.0)
    off = Clearance(growth=0.04, oncoming=0.0, upper=2.0)
    [cost] = cost_of(problem, inputs, clearance=shared).cost
    assert cost == pytest.approx(cost_of(problem, inputs, clearance=alone).cost[0], abs=1e-9)
    assert cost > cost_of(problem, inputs, clearance=off).cost[0] + 0.01


@pytest.mark.parametrize("table", [arc_table(640), perturbations(80)])
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
def test_candidates_obey_the_limits_and_are_rollouts_of_their_inputs(seed, people, kinematics):
    problem = drawn(seed, people, kinematics)
    now = wheels(problem)
    low, high, rise, fall = problem.input_bounds()
    candidates = candidates_of(problem)
    assert len(candidates) >= 1
    assert (np.diff(candidates.cost) >= 0.0).all()
    assert candidates.step * candidates.inputs.shape[1] >= 6.0 - 1e-9
    for inputs, poses in zip(candidates.inputs, candidates.poses, strict=True):
        rolled = problem.robot.motion_model.rollout(problem.pose, inputs, candidates.step)
        assert np.abs(rolled - poses).max() < 1e-9
        change = np.diff(np.vstack([now, inputs]), axis=0)
        assert (change <= rise * STEP + 1e-9).all()
        assert (change >= -fall * STEP - 1e-9).all()
        assert (inputs <= np.maximum(high, now) + 1e-9).all()
        assert (inputs >= np.minimum(low, now) - 1e-9).all()
        joint = problem.robot.motion_model.translating
        speed = np.linalg.norm(inputs[:, :joint], axis=1)
        assert speed.max() <= max(problem.top_speed, np.linalg.norm(now[:joint])) + 1e-9


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_or_mirrored_world_has_turned_or_mirrored_candidates(seed, kinematics):
    problem = drawn(seed, 5, kinematics)
    candidates = candidates_of(problem)
    other = candidates_of(turned(problem, np.array([2.0, -1.0, np.pi / 2.0])))
    assert np.abs(other.inputs[0] - candidates.inputs[0]).max() < 1e-6
    flipped = candidates_of(mirrored(problem))
    assert (
        np.abs(flipped.inputs[0] * MIRROR[len(wheels(problem))] - candidates.inputs[0]).max() < 1e-6
    )


def test_the_same_problem_gives_the_same_candidates():
    problem = drawn(3, 8)
    assert identical(candidates_of(problem), candidates_of(problem))


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
def test_candidates_keep_their_score_when_they_are_evaluated_again(kinematics):
    problem = drawn(5, 8, kinematics)
    candidates = candidates_of(problem)
    again = cost_of(problem, candidates.inputs)
    np.testing.assert_allclose(again.cost, candidates.cost, rtol=1e-12)
    np.testing.assert_array_equal(again.passing_sides, candidates.passing_sides)


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
@pytest.mark.parametrize("seed", range(4))
def test_search_and_solver_evaluate_one_objective(seed, kinematics):
    """The cost of a candidate is that of the SQP's objective at its inputs, term by term."""
    problem = drawn(seed, 5, kinematics)
    tables = prepared(problem)
    found = sample(tables, BUDGET)
    for k in range(len(found)):
        if gap_to(problem.walls, found.poses[k]) < 0.02:
            continue  # the search adds the cost of a stop before the wall
        again = tables.evaluate(found.inputs[k])
        assert again.cost == pytest.approx(found.cost[k])
        assert list(again.costs.values()) == pytest.approx(found.by_term[k])
        assert sum(again.costs.values()) == pytest.approx(again.cost)
        assert again.slack == pytest.approx(found.slack[k])


def test_the_order_of_trajectories_does_not_matter():
    tables = prepared(drawn(5, 6))
    inputs = sample(tables, BUDGET).inputs
    there, back = evaluate(tables, inputs), evaluate(tables, inputs[::-1])
    assert identical(there.cost, back.cost[::-1])
    assert identical(there.by_term, back.by_term[::-1])


def test_the_last_plan_is_among_the_candidates():
    problem = scene(speed=0.8, people=walkers([[4.0, 0.3, -0.8, 0.0]]))
    first = candidates_of(problem)
    warm = Trajectory(
        step=STEP, poses=first.poses[0], inputs=first.inputs[0], current_input=wheels(problem)
    )
    assert candidates_of(problem, warm=warm).cost[0] <= first.cost[0] + 1e-12


@pytest.mark.parametrize("kinematics", ["unicycle", "holonomic"])
def test_alone_at_pace_straight_on_loses_nothing(kinematics):
    candidates = candidates_of(scene(kinematics, speed=0.8))
    assert candidates.cost[0] < 0.01
    assert candidates.inputs[0, :, 0] == pytest.approx(0.8, abs=0.02)


def test_an_oncoming_person_is_passed_on_either_side():
    problem = scene(speed=0.8, people=walkers([[5.0, 0.05, -0.8, 0.0]]))
    candidates = candidates_of(problem)
    assert {-1, 1} <= set(candidates.passing_sides[:, 1])
    # passed on the right, he is seen to the left: the bearing to him turns counter-clockwise
    right = int(np.argmax(candidates.passing_sides[:, 1] == 1))
    assert candidates.poses[right, :, 1].min() < -0.2


def test_a_less_likely_hypothesis_and_a_later_contact_cost_less():
    """Straight on at 0.8 m/s into someone who stands: the price is proportional to his weight."""
    alone, straight = scene(speed=0.8), np.tile([0.8, 0.0], (38, 1))

    def price(x, weight):
        problem = scene(speed=0.8, people=walkers([[x, 0.0, 0.0, 0.0]]))
        p = dataclasses.replace(problem.predictions, weight=np.full((1, 1), weight))
        problem = dataclasses.replace(problem, predictions=p)
        return cost_of(problem, straight, CLEARANCE_ALONE).cost[0]

    nobody = cost_of(alone, straight, CLEARANCE_ALONE).cost[0]
    assert price(2.5, 0.5) - nobody == pytest.approx(0.5 * (price(2.5, 1.0) - nobody))
    assert price(2.5, 1.0) > price(3.5, 1.0) > nobody


def test_standing_people_may_be_passed_more_closely_than_walking_people():
    """8 cm beside somebody, where who walks is to be passed at 12 cm and who stands at 4.8 cm."""
    straight = np.tile([0.8, 0.0], (38, 1))
    close, same = (Clearance(now=0.12, growth=0.0, standing=share) for share in (0.4, 1.0))

    def price(clearance, *people):
        problem = scene(speed=0.8, people=walkers(np.reshape(people, (-1, 4))))
        return cost_of(problem, straight, CLEARANCE_ALONE, clearance).cost[0]

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
    hit, clear = (cost_of(p, stand) for p in (into, past))
    assert hit.cost[0] > clear.cost[0] + 1.0


def test_somebody_far_away_changes_nothing():
    alone = candidates_of(scene(speed=0.6))
    far = candidates_of(scene(speed=0.6, people=walkers([[-30.0, 20.0, 0.0, 0.0]])))
    np.testing.assert_array_equal(far.inputs, alone.inputs)
    np.testing.assert_array_equal(far.cost, alone.cost)


def test_no_candidate_leads_between_the_members_of_a_group():
    """Two who stand 1.8 m apart: one drives between them only where they do not belong together."""
    people = walkers([[3.0, 0.9, 0.0, 0.0], [3.0, -0.9, 0.0, 0.0]])
    predictions = straight_on(people, 25, STEP)
    together = Groups(id=np.array([1]), member=np.array([0, 0]))

    def between(groups):
        spaces = PersonalSpace().spaces(
            people, groups, predictions, np.zeros(3), RiderProfile(social_distance=0.2)
        )
        problem = dataclasses.replace(scene(speed=0.8, people=people), spaces=spaces)
        poses = candidates_of(problem).poses[0]
        return ((np.abs(poses[:, 0] - 3.0) < 0.3) & (np.abs(poses[:, 1]) < 0.9)).any()

    assert between(Groups.alone(2))
    assert not between(together)


def test_a_box_on_the_path_is_passed_on_either_side_without_contact():
    walls = distance_field(room(boxes=[(4.5, 3.7, 5.0, 4.3)]))
    candidates = candidates_of(scene(pose=(2.0, 4.0, 0.0), speed=0.6, wanted=0.6, walls=walls))
    assert gap_to(walls, candidates.poses[0]) > 0.0
    assert candidates.poses[0, -1, 0] > 4.0  # it gets on
    assert {-1, 1} <= set(candidates.passing_sides[:, 0])


def gap_to(walls, poses):
    discs = load_robot("quantum_q6_edge").discs
    return (walls.at(transform(poses[:, None, :], discs[:, :2])) - discs[:, 2]).min()


def test_the_best_candidate_stops_before_a_wall_across_the_path():
    walls = distance_field(room(boxes=[(5.0, 0.0, 5.5, 8.0)]))
    candidates = candidates_of(scene(pose=(2.0, 4.0, 0.0), speed=0.6, wanted=0.6, walls=walls))
    assert gap_to(walls, candidates.poses[0]) > 0.0
    assert candidates.poses[0, :, 0].max() < 5.0 - 0.5


def test_a_short_trajectory_returns_to_the_path():
    problem = scene(pose=(0.0, 0.5, 0.3), speed=0.8)
    line = dataclasses.replace(
        problem.reference, poses=scene().reference.poses
    )  # along the x-axis, half a metre to the right
    problem = dataclasses.replace(problem, reference=line)
    found = cost_of(problem, np.tile([0.8, 0.0], (3, 1)))
    assert found.inputs.shape[1] == 38
    assert abs(found.poses[0, -1, 1]) < 0.1
