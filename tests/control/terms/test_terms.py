"""Terms of the objective: values derived by hand, and local models by finite differences."""

import dataclasses
import math

import numpy as np
import pytest

from cohelm.control.objective_tables import BODIES, TERMS
from cohelm.control.path import project_on_path
from cohelm.control.stack import TrackingTerms
from cohelm.control.terms import (
    Barrier,
    FinalHeading,
    GroupSpace,
    InputChange,
    InputDeviation,
    PathDistance,
    PersonalSpaceCost,
    PersonClearance,
    Progress,
    TrackReference,
    WallBarrier,
    WallClearance,
)
from cohelm.messages import GroupSpaces
from cohelm.robots.clearance import Clearance
from cohelm.shapes import CONTOUR, ELLIPSE, PRINTED
from cohelm.testing.problems import field_of, random_problem
from cohelm.testing.scenes import local_problem, straight_reference, walkers

NO_BARRIER = Barrier(l1=0.0, l2=0.0)
BARRIERS = {"bodies": NO_BARRIER, "social_space": NO_BARRIER, "walls": WallBarrier(l1=0.0, l2=0.0)}
NOTHING = {
    "progress": Progress(final=0.0, mean=0.0),
    "path_distance": PathDistance(weight=0.0),
    "final_heading": FinalHeading(weight=0.0),
    "input_effort": InputDeviation(turn=0.0),
    "input_change": InputChange(speed=0.0, turn=0.0),
    "track_reference": TrackReference(),
    "person_clearance": PersonClearance(weight=0.0),
    "personal_space": PersonalSpaceCost(weight=0.0),
    "group_space": GroupSpace(weight=0.0),
    "wall_clearance": WallClearance(weight=0.0),
}
EACH = {
    "progress": Progress(final=1.3, mean=0.8),
    "path_distance": PathDistance(weight=0.5),
    "final_heading": FinalHeading(weight=2.0),
    "input_effort": InputDeviation(speed=0.8, turn=0.25),
    "input_change": InputChange(speed=0.08, turn=0.04),
    "track_reference": TrackReference(position=1.0, heading=0.3, terminal=4.0),
    "person_clearance": PersonClearance(weight=40.0),
    "personal_space": PersonalSpaceCost(weight=2.0),
    "group_space": GroupSpace(weight=20.0),
    "wall_clearance": WallClearance(weight=3.0, distance=0.5),
}
assert set(EACH) == set(NOTHING) == set(TERMS[:BODIES])
WIDE = Clearance(now=0.8, growth=0.1, upper=1.0)
MOVES = ("as a chair", "any way")


def only(name, term=None, **others):
    """Terms without any but one."""
    return TrackingTerms(**NOTHING | BARRIERS | {name: term or EACH[name]} | others)


def grouped(problem, radius=0.9):
    """The problem with a group of two, 2 m apart, 1.2 m ahead of the robot."""
    steps = len(problem.reference.speeds)
    direction = 2.0 * np.pi * np.arange(32) / 32
    u = np.stack([np.cos(direction), np.sin(direction)])
    cos, sin = math.cos(problem.pose[2]), math.sin(problem.pose[2])
    points = np.array([[1.2, 1.0], [1.2, -1.0]]) @ [[cos, sin], [-sin, cos]] + problem.pose[:2]
    support = np.tile((points @ u).max(axis=0) + radius, (1, steps, 1))
    groups = GroupSpaces(id=np.arange(1), direction=direction, support=support)
    return dataclasses.replace(problem, spaces=dataclasses.replace(problem.spaces, groups=groups))


def among(rng, moves, motions, shape=(CONTOUR, 0.125)):
    """A problem with people close by, a group and walls."""
    problem = random_problem(rng, 8, steps=12).problem
    spaces = dataclasses.replace(
        problem.spaces, kind=shape[0], scale=shape[1], floor=0.1, robot=np.array([0.3, 0.2, 0.15])
    )
    # a wall to the left, which the footprint's discs approach at an angle
    angle = problem.pose[2] - 1.3
    normal = np.array([np.cos(angle), np.sin(angle)])
    plane = np.array([[*normal, normal @ problem.pose[:2] - 0.8]])
    walls = field_of(plane, problem.pose)
    problem = grouped(dataclasses.replace(problem, spaces=spaces, walls=walls))
    return problem if moves == MOVES[0] else motions.any_way(problem)


def beyond_a_segment(tables, inputs):
    """Check that some state is between the normals of two segments of the path.

    The arc length is constant there, and the model keeps its slope.
    """
    samples, i, found = tables.scene.path.samples, 0, False
    for x, y, _ in tables.trajectory(inputs).poses.tolist():
        i, _, _ = project_on_path(samples, x, y, i)
        t = (x - samples[i, 0]) * samples[i, 2] + (y - samples[i, 1]) * samples[i, 3]
        found |= not -1e-4 < t < 0.1 + 1e-4
    return found


def check_model(tables, inputs, motions, *, exact=True):
    """The condensed gradient is the derivative of the cost; the curvature has no negative value."""
    space, _ = motions.linearised(tables, inputs)
    numeric = motions.slope(lambda u: motions.cost_of(tables, u), inputs)
    if exact:
        largest = np.abs(numeric).max()
        assert np.abs(space.program.gradient - numeric).max() < 1e-6 * largest + 1e-6
    q = space.model
    xx, xy, xa, yy, ya, aa = q.pose_curvature.T
    curvature = np.array([[xx, xy, xa], [xy, yy, ya], [xa, ya, aa]]).transpose(2, 0, 1)
    assert np.linalg.eigvalsh(curvature).min() > -1e-9
    assert np.linalg.eigvalsh(space.program.hessian).min() > 0.0
    return float(np.abs(numeric).max())


@pytest.mark.parametrize("moves", MOVES)
@pytest.mark.parametrize("name", EACH)
def test_the_model_of_a_term_is_the_derivative_of_its_cost(name, moves, motions):
    rng, slopes = np.random.default_rng(3), []
    for _ in range(4):
        problem = among(rng, moves, motions)
        tables = motions.prepared(problem, only(name), clearance=WIDE)
        inputs = motions.wandering(problem, rng).inputs
        smooth = name != "progress" or not beyond_a_segment(tables, inputs)
        slopes.append(smooth * check_model(tables, inputs, motions, exact=smooth))
    assert max(slopes) > 1e-3


@pytest.mark.parametrize("shape", [(CONTOUR, 0.125), (PRINTED, 0.104), (ELLIPSE, 0.125)])
def test_the_model_of_personal_space_holds_for_each_shape(shape, motions):
    rng = np.random.default_rng(4)
    slopes = []
    for _ in range(4):
        problem = among(rng, MOVES[0], motions, shape)
        tables = motions.prepared(problem, only("personal_space"))
        slopes.append(check_model(tables, motions.wandering(problem, rng).inputs, motions))
    assert max(slopes) > 1e-3


def test_slow_robots_are_blamed_less_and_the_model_knows(motions):
    """Below 0.2 m/s the share of blame has a slope of its own."""
    problem = local_problem(steps=8, step=0.2, people=walkers([[1.0, 0.3, 0.0, 0.0]]))
    tables = motions.prepared(problem, only("person_clearance"), np.zeros(2), clearance=WIDE)
    inputs = np.column_stack([np.linspace(0.02, 0.15, 8), np.linspace(0.0, 0.1, 8)])
    assert check_model(tables, inputs, motions) > 0.0


def test_nothing_costs_anything_on_the_reference(motions):
    problem = local_problem(steps=10, step=0.2, speed=0.8, wanted=0.8)
    terms = TrackingTerms(
        track_reference=EACH["track_reference"], input_effort=EACH["input_effort"]
    )
    costs = motions.prepared(problem, terms).evaluate(np.tile([0.8, 0.0], (10, 1))).costs
    assert max(costs.values()) < 1e-9
    assert tuple(costs) == TERMS


@pytest.fixture(scope="module")
def costs_of(motions):
    """Costs by name of constant inputs over ten steps of 0.2 s, 0.8 m/s wanted."""

    def made(inputs=(0.0, 0.0), *, now=(0.0, 0.0), clearance=None, terms=None, **changes):
        scene = {key: changes.pop(key) for key in ("people", "walls") if key in changes}
        problem = local_problem(steps=10, step=0.2, wanted=0.8, **scene)
        problem = dataclasses.replace(problem, **changes)
        tables = motions.prepared(problem, terms, np.array(now), clearance=clearance or Clearance())
        return tables.evaluate(np.tile(np.array(inputs, dtype=float), (10, 1))).costs

    return made


def test_progress_by_hand(costs_of):
    """The reference leaves a standing robot behind by 0.16 m a step, that is 0.2 s."""
    progress = Progress(final=2.0, mean=3.0)
    found = costs_of(terms=only("progress", progress))["progress"]
    end = math.hypot(1.6, 1e-3) - 1e-3
    # mean: Σ k, k = 1…10, over ten steps
    assert found == pytest.approx(2.0 * end / 0.8 + 3.0 * 0.2 * 55 / 10)


def test_a_robot_ahead_of_the_reference_has_lost_nothing(costs_of):
    """At 1 m/s instead of 0.8 m/s, and at the end beside nothing."""
    assert costs_of((1.0, 0.0))["progress"] == pytest.approx(0.0, abs=1e-12)


def test_path_distance_by_hand(costs_of):
    """0.5 m to the left for 2 s: 0.08 · 0.25 · 2 s."""
    reference = straight_reference(np.array([0.0, -0.5, 0.0]), 0.8, 10, 0.2)
    found = costs_of((0.8, 0.0), reference=reference)
    assert found["path_distance"] == pytest.approx(0.08 * 0.25 * 2.0)


def test_final_heading_by_hand(costs_of):
    """The path 2 m ahead is at an angle of 0.5 rad."""
    reference = straight_reference(np.array([0.0, 0.0, 0.5]), 0.8, 10, 0.2)
    assert costs_of(reference=reference)["final_heading"] == pytest.approx(1.0 - math.cos(0.5))


def test_inputs_by_hand(costs_of):
    """2 s at 0.3 m/s and 0.5 rad/s, begun at rest."""
    found = costs_of(
        (0.3, 0.5), terms=TrackingTerms(input_effort=InputDeviation(speed=0.7, turn=0.15))
    )
    assert found["input_effort"] == pytest.approx(2.0 * (0.7 * 0.5**2 + 0.15 * 0.5**2))
    # 0.3 m/s in 0.2 s is 1.5 m/s², and 2.5 rad/s²
    assert found["input_change"] == pytest.approx(0.2 * 0.016 * (1.5**2 + 2.5**2))
    assert costs_of((0.3, 0.5), now=(0.3, 0.5))["input_change"] == 0.0
    printed = TrackingTerms(input_effort=InputDeviation(input_cost="printed", speed=0.7, turn=0.0))
    assert costs_of((0.3, 0.5), terms=printed)["input_effort"] == pytest.approx(1.4 * 0.3**2)


def test_track_reference_by_hand(costs_of):
    """Σ (0.16 k)², k = 1…10, Σ k² = 385; the last one counts 0.2 + 4 s."""
    terms = TrackingTerms(track_reference=TrackReference(position=1.0, heading=0.3))
    found = costs_of(terms=terms)["track_reference"]
    assert found == pytest.approx(0.2 * 0.0256 * 385 + 4.0 * 2.56)
    # a reference that has turned once round is a whole turn away
    turned = straight_reference(np.zeros(3), 0.8, 10, 0.2)
    turned = dataclasses.replace(turned, poses=turned.poses + np.array([0.0, 0.0, 2.0 * np.pi]))
    assert costs_of(terms=terms, reference=turned)["track_reference"] - found == pytest.approx(
        (0.2 * 10 + 4.0) * 0.3 * (2.0 * np.pi) ** 2
    )


def fading(costs):
    """Costs of ten steps of 0.2 s by the age of predictions."""
    return float(np.sum(costs * np.exp(-0.2 * np.arange(1, 11) / 4.0)))


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.4), (0.1, 0.7), (0.2, 1.0)])
def test_costs_of_people_by_hand(speed, share, costs_of, chair):
    """A person who stands 1 m aside of the axle; a robot that turns about it has less blame."""
    gap = 1.0 - chair.capsule[4] - 0.25
    people = walkers([[0.1, 1.0, 0.0, 0.0]])
    still = Clearance(now=2.0 * gap, growth=0.0, upper=3.0, standing=1.0)
    found = costs_of((speed, 0.0), people=people, clearance=still)
    # along the straight side of the capsule the gap stays
    assert 0.1 - speed * 2.0 > chair.capsule[0]
    assert found["person_clearance"] == pytest.approx(
        share * 60.0 * 0.2 * fading(gap**2 * np.ones(10)), rel=1e-4
    )
    # the space reaches 0.45 m
    assert gap < 0.45
    assert found["personal_space"] == pytest.approx(
        share * 0.8 * 0.2 * fading((1.0 - gap / 0.45) ** 2 * np.ones(10)), rel=1e-4
    )


def test_unlikely_hypotheses_cost_less(costs_of):
    people = walkers([[0.0, 1.0, 0.0, 0.0]])
    problem = local_problem(steps=10, step=0.2, people=people)
    half = dataclasses.replace(problem.predictions, weight=np.array([[0.5]]))
    wide = Clearance(now=0.6, upper=1.0, standing=1.0)
    whole, less = (
        costs_of(people=people, clearance=wide, predictions=p) for p in (problem.predictions, half)
    )
    for name in ("person_clearance", "personal_space"):
        assert whole[name] > 0.0
        assert less[name] == pytest.approx(0.5 * whole[name])
    # a barrier counts a person's most likely hypothesis whatever its probability
    assert less["bodies"] == whole["bodies"]


def test_group_space_by_hand(costs_of, chair):
    """The hull begins 0.3 m ahead of the axle; the robot is a disc about its middle."""
    problem = grouped(local_problem(steps=10, step=0.2))
    middle = 0.5 * (chair.capsule[0] + chair.capsule[2])
    depth = middle + chair.capsule[4] - 0.3
    found = costs_of(spaces=problem.spaces)["group_space"]
    assert found == pytest.approx(0.4 * 60.0 * 0.2 * fading(depth**2 * np.ones(10)))


def test_wall_clearance_by_hand(costs_of, chair):
    """A wall 5 cm from the chair's side, where 0.1 m and the rider's clearance are wanted."""
    side = chair.discs[:, 2].max()
    planes = np.array([[0.0, 1.0, -side - 0.05]])
    problem = local_problem(steps=10, step=0.2)
    found = costs_of(walls=field_of(planes, problem.pose))
    wanted = 0.1 + problem.profile.clearance
    assert found["wall_clearance"] == pytest.approx(
        0.5 * 2.0 * (1.0 - 0.05 / wanted) ** 2, rel=1e-4
    )
    missing = max(problem.profile.clearance - 0.05, 0.0)
    assert found["walls"] == pytest.approx(4.0 * missing + 2.0 * missing**2, rel=1e-4, abs=1e-6)


def test_a_holonomic_robot_may_face_any_way(motions):
    """Along the reference at its speed, looking to its left: no effort but in facing."""
    problem = motions.any_way(local_problem(steps=5, step=0.2, wanted=0.8))
    problem = dataclasses.replace(problem, pose=np.array([0.0, 0.0, np.pi / 2.0]))
    terms = TrackingTerms(input_effort=InputDeviation(speed=1.0))
    costs = motions.prepared(problem, terms).evaluate(np.tile([0.0, -0.8, 0.0], (5, 1))).costs
    assert costs["input_effort"] < 1e-12
    assert costs["progress"] < 1e-9
    assert costs["final_heading"] == pytest.approx(1.0)
