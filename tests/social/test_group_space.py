import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from cohelm.messages import Groups, Predictions, RiderProfile
from cohelm.shapes import (
    CONTOUR,
    PRINTED,
    RadialShape,
    distance_to_hull,
    hull_outline,
    outline,
    support,
)
from cohelm.social import PersonalSpace
from cohelm.testing.scenes import BODY, straight_on, walkers

REST = np.zeros(3)
STROLL = np.array([[0.0, 0.0, 1.2, 0.3], [0.4, 0.9, 1.1, 0.2], [-0.8, 0.2, 0.9, 0.4]])
THREE = Groups(id=[4], member=[0, 0, 0])


def spaces(people, groups, predictions=None, **parameters):
    model = PersonalSpace(PersonalSpace.Parameters(**parameters))
    predictions = predictions or straight_on(people, 10, 0.1)
    return model.spaces(people, groups, predictions, REST, RiderProfile())


def outlines(people, told, step=0, *, steps=0.1):
    """All members' outlines, closely sampled, body and all."""
    return np.concatenate(
        [
            outline(
                told.shape(i, 0, step), BODY,
                np.array([*(x[:2] + step * steps * x[2:]), told.axis[i, 0, step]]), 720,
            )
            for i, x in enumerate(people.mean)
        ]
    )  # fmt: skip


@pytest.mark.parametrize("step", [0, 10])
def test_is_the_hull_of_the_members_outlines(step):
    people = walkers(STROLL)
    told = spaces(people, THREE, directions=64)
    sampled = outlines(people, told, step)
    corners = sampled[ConvexHull(sampled).vertices]
    u = np.stack([np.cos(told.groups.direction), np.sin(told.groups.direction)])
    excess = told.groups.support[0, step] - (corners @ u).max(axis=0)
    # the body's disc goes round the egg here and is added along the ray there: never less, and
    # more by r (1 − cos(angle of ray and normal)), which is below 30° for 2 : 1
    assert excess.min() > -1e-4
    assert excess.max() < BODY * (1.0 - np.cos(np.radians(30.0)))


def test_two_circles_have_a_stadium():
    # two at rest, 2 m apart: floor and body about each, straight between
    people = walkers([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]])
    told = spaces(people, Groups(id=[1], member=[0, 0]))
    reach = told.floor + BODY
    expected = reach + 2.0 * np.maximum(np.cos(told.groups.direction), 0.0)
    assert told.groups.support[0, 0] == pytest.approx(expected)
    ring = hull_outline(told.groups.direction, told.groups.support[0, 0])
    x, y = ring[:-1].T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    # a regular polygon of m sides about a circle has the area m tan(π/m) r²
    assert area == pytest.approx(2.0 * 2.0 * reach + 32.0 * np.tan(np.pi / 32.0) * reach**2)


def test_turns_and_moves_with_the_world():
    people = walkers(STROLL)
    told = spaces(people, THREE).groups
    turn, shift = 2.0 * np.pi * 5 / 32, np.array([3.0, -7.0])
    cos, sin = np.cos(turn), np.sin(turn)
    R = np.array([[cos, sin], [-sin, cos]])
    moved = np.concatenate([STROLL[:, :2] @ R + shift, STROLL[:, 2:] @ R], axis=1)
    after = spaces(walkers(moved), THREE).groups
    u = np.stack([np.cos(after.direction), np.sin(after.direction)])
    assert after.support == pytest.approx(np.roll(told.support, 5, axis=-1) + shift @ u)


def test_everyone_is_where_they_most_likely_go():
    people = walkers(STROLL[:2])
    one = straight_on(people, 10, 0.1)
    stay = np.zeros_like(one.velocity)
    both = Predictions(
        step=0.1,
        names=("keeps_going", "stops"),
        weight=np.array([[0.7, 0.3], [0.7, 0.3]]),
        mean=np.concatenate([one.mean, one.mean[:, :, :1].repeat(11, axis=2)], axis=1),
        velocity=np.concatenate([one.velocity, stay], axis=1),
        deviation=np.concatenate([one.deviation] * 2, axis=1),
    )
    pair = Groups(id=[1], member=[0, 0])
    expected = spaces(people, pair, one).groups.support
    assert spaces(people, pair, both).groups.support == pytest.approx(expected)


def test_nobody_and_loners_have_no_group_space():
    for states in (np.empty((0, 4)), STROLL):
        told = spaces(walkers(states), Groups.alone(len(states))).groups
        assert told.support.shape == (0, 11, 32)


def test_as_printed_it_is_the_hull_too():
    people = walkers(STROLL)
    told = spaces(people, THREE, shape="printed")
    assert told.kind == PRINTED
    sampled = outlines(people, told)
    u = np.stack([np.cos(told.groups.direction), np.sin(told.groups.direction)])
    excess = told.groups.support[0, 0] - (sampled @ u).max(axis=0)
    assert excess.min() > -0.01  # sampled every 5°: some tenths of a per cent of 1.2 m
    assert excess.max() < BODY * (1.0 - np.cos(np.radians(45.0)))


# --- the support function itself -------------------------------------------------------------

sigmas = st.floats(0.2, 3.0)


@settings(max_examples=60)
@given(
    kind=st.sampled_from([CONTOUR, PRINTED]), front=sigmas, side=sigmas, rear=sigmas,
    floor=st.floats(0.0, 1.5), phi=st.floats(-3.1, 3.1),
)  # fmt: skip
def test_the_support_is_the_farthest_of_the_outline(kind, front, side, rear, floor, phi):
    shape = RadialShape(kind, front, side, rear, 0.125, floor)
    ring = outline(shape, 0.0, REST, 3600)
    farthest = (ring @ np.array([np.cos(phi), np.sin(phi)])).max()
    # as printed a fast egg is a spike, and one in 5° may miss its tip
    got = support(shape, np.cos(phi), np.sin(phi))
    assert got == pytest.approx(farthest, rel=1e-4 if kind == CONTOUR else 0.3, abs=1e-4)
    assert got >= floor


def circle_of(m, radius=1.5):
    direction = 2.0 * np.pi * np.arange(m) / m
    return direction, np.full(m, radius)


@pytest.mark.parametrize("m", [8, 32, 128, 512])
def test_the_distance_to_a_circle_is_right_to_one_in_m_squared(m):
    rng = np.random.default_rng(0)
    points = rng.uniform(-4, 4, (400, 2))
    away = np.hypot(*points.T)
    got, gradient = distance_to_hull(*circle_of(m), points)
    # the best direction is at most π/m off: a loss of |p| (1 − cos(π/m))
    assert (got <= away - 1.5 + 1e-12).all()
    assert (got >= away * np.cos(np.pi / m) - 1.5 - 1e-12).all()
    assert np.hypot(*gradient.T) == pytest.approx(np.ones(400))


def test_the_gradient_is_the_finite_difference():
    people = walkers(STROLL)
    told = spaces(people, THREE).groups
    hull = told.direction, told.support[0, 0]
    points = np.random.default_rng(1).uniform(-5, 5, (200, 2))
    value, gradient = distance_to_hull(*hull, points)
    e = 1e-7
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = e
        more, _ = distance_to_hull(*hull, points + step)
        less, _ = distance_to_hull(*hull, points - step)
        smooth = np.isclose(more - value, value - less, atol=1e-12)  # not across an edge
        slope = (more - less)[smooth] / (2 * e)
        assert smooth.mean() > 0.99
        assert slope == pytest.approx(gradient[smooth, axis], abs=1e-6)


def test_points_of_the_outline_lie_on_the_hull_and_enclose_it():
    people = walkers(STROLL)
    told = spaces(people, THREE)
    hull = told.groups.direction, told.groups.support[0, 0]
    ring = hull_outline(*hull)
    assert ring[0] == pytest.approx(ring[-1])
    assert distance_to_hull(*hull, ring)[0] == pytest.approx(np.zeros(33), abs=1e-9)
    assert (distance_to_hull(*hull, outlines(people, told))[0] <= 1e-9).all()
