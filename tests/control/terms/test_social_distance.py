import numpy as np
import pytest

from cohelm.control.terms.constraints.person_barrier import person_barrier, person_gradient
from cohelm.control.terms.constraints.social_distance import (
    SpaceShapes,
    coefficients,
    max_extent,
    social_barrier,
    social_gradient,
)
from cohelm.shapes import CONTOUR, ELLIPSE, PRINTED, RadialShape, extent
from cohelm.testing.problems import random_problem

PUSH = 1e-6
# about the chair, whose spine reaches from −0.35 to 0.54 m and whose capsule is 0.32 m thick
WHERE = {
    "ahead": (1.6, 0.3),
    "aside": (0.2, 1.3),
    "beside the spine": (0.1, -0.7),
    "behind": (-1.4, -0.4),
    "touching": (0.8, 0.1),
}
SHAPES = {"contour": (CONTOUR, 0.125), "printed": (PRINTED, 0.104), "ellipse": (ELLIPSE, 0.125)}
EVERY = np.ones((1, 1), dtype=bool)
EGG = (1.6, 1.07, 0.8)
OWN = (0.4, 0.27, 0.2)


def slope_in_pose(h, pose):
    out = np.empty(3)
    for a in range(3):
        push = np.zeros(3)
        push[a] = PUSH
        out[a] = (h(pose + push) - h(pose - push)) / (2.0 * PUSH)
    return out


def about(shape, axis, where):
    """What the kernels take of one person, whose space has an axis, at one step."""
    kind, scale = SHAPES[shape]
    eggs = coefficients(kind, scale, *(np.array([[sigma]]) for sigma in EGG))
    direction = np.array([[[np.cos(axis), np.sin(axis)]]])
    robot = coefficients(kind, scale, *np.array(OWN))
    return np.array([[where]]), SpaceShapes(kind, direction, eggs, 0.1, robot, 0.02)


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("heading", [0.0, 2.1])
def test_the_body_gradient_is_a_derivative_wherever_a_person_is(where, heading, chair):
    person, kept = np.array([[WHERE[where]]]), np.array([[0.35]])
    pose = np.array([0.0, 0.0, heading])
    numeric = slope_in_pose(
        lambda p: person_barrier(chair.capsule, p[None], person, kept)[0, 0], pose
    )
    exact = person_gradient(chair.capsule, pose[None], person, EVERY)[0, 0]
    assert np.abs(exact - numeric).max() < 1e-6


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("axis", [0.4, 2.8, -1.7])
def test_the_social_gradient_is_a_derivative_wherever_a_person_is(where, shape, axis, chair):
    person, space = about(shape, axis, WHERE[where])
    kept = np.array([[0.25]])
    for heading in (0.0, 0.9):
        pose = np.array([0.0, 0.0, heading])
        numeric = slope_in_pose(
            lambda p: social_barrier(chair.capsule, p[None], person, kept, space)[0, 0], pose
        )
        cut = min(1.0, 2.0 / np.hypot(*numeric[:2]))
        exact = social_gradient(chair.capsule, pose[None], person, space, EVERY)[0, 0]
        # the distance is √(e² + 1e-6), so that directions are too short by ½ · 1e-6/e² and turn by
        # as much too little: e > 0.25 m and slopes of up to 2 and lengths of 3 m, ½ · 16e-6 · 7
        assert np.abs(exact - cut * numeric).max() < 6e-5


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("axis", [0.0, 0.7, 2.0, -2.9])
def test_extents_are_those_of_the_shapes(shape, axis, chair):
    """A person 3 m ahead of a chair that faces him: δ_i is from his axis to −x, δ is 0."""
    kind, scale = SHAPES[shape]
    person, space = about(shape, axis, (3.0, 0.0))
    pose = np.zeros((1, 3))
    plain = person_barrier(chair.capsule, pose, person, np.array([[0.25]]))
    h = social_barrier(chair.capsule, pose, person, np.array([[0.25]]), space)
    theirs, _ = extent(RadialShape(kind, *EGG, scale, 0.1), np.pi - axis)
    mine, _ = extent(RadialShape(kind, *OWN, scale, 0.02), 0.0)
    assert plain - h == pytest.approx(theirs + mine)


@pytest.mark.parametrize("shape", SHAPES)
def test_no_extent_is_above_the_maximum(shape):
    kind, scale = SHAPES[shape]
    most = max_extent(kind, scale, *(np.array([sigma]) for sigma in EGG), 0.1)
    egg = RadialShape(kind, *EGG, scale, 0.1)
    every = [extent(egg, d)[0] for d in np.linspace(-np.pi, np.pi, 361)]
    assert max(every) == pytest.approx(most)


def test_gradients_are_zero_where_nobody_asks():
    rng = np.random.default_rng(0)
    problem = random_problem(rng, 4, steps=3).problem
    poses, people = np.tile(problem.pose, (4, 1)), problem.predictions.mean[:, 0]
    near = rng.random((4, 4)) < 0.5
    gradient = person_gradient(problem.robot.capsule, poses, people, near)
    assert (gradient[~near] == 0.0).all()
    assert (np.hypot(gradient[near][:, 0], gradient[near][:, 1]) > 0.99).all()


def test_random_problems_begin_clear_of_contact_unless_hopeless(rng):
    for people in (0, 3, 12):
        problem = random_problem(rng, people).problem
        h = person_barrier(
            problem.robot.capsule,
            problem.pose[None],
            problem.predictions.mean[:, 0, :1],
            problem.people.radius[:, None],
        )
        assert h.min(initial=1.0) > 0.0
