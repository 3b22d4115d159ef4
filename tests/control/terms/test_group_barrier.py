import dataclasses

import numpy as np
import pytest

from cohelm.control.terms import GroupBarrier
from cohelm.control.terms.constraints.group_barrier import group_barrier
from cohelm.geometry import transform
from cohelm.messages import GroupSpaces
from cohelm.shapes import distance_to_hull, hull_outline
from cohelm.testing.scenes import local_problem

STEPS = 8


def among(centres, radius=0.9, *, velocity=(0.0, 0.0), directions=32, **problem):
    """A problem with the hulls of discs of ``radius`` about each group's ``centres`` (g, k, 2)."""
    scene = local_problem(steps=STEPS, step=0.2, **problem)
    direction = 2.0 * np.pi * np.arange(directions) / directions
    u = np.stack([np.cos(direction), np.sin(direction)])
    times = 0.2 * np.arange(STEPS + 1)
    points = np.asarray(centres, dtype=float)[:, None] + times[:, None, None] * velocity
    groups = GroupSpaces(
        id=np.arange(len(points)), direction=direction, support=(points @ u).max(axis=2) + radius
    )
    return dataclasses.replace(scene, spaces=dataclasses.replace(scene.spaces, groups=groups))


def rows_at(problem, trajectory, motions, constraint=None):
    constraint = constraint or GroupBarrier()
    there = constraint.values(problem, trajectory)
    return constraint.rows(problem, trajectory, motions.sensitivity(problem, trajectory), there)


def test_distances_by_hand(motions, chair):
    """Two who talk 5 m ahead, 2 m apart: the hull's nearest side is 0.9 m before them."""
    problem = among([[[5.0, 1.0], [5.0, -1.0]]])
    found = GroupBarrier().values(problem, motions.standing(problem))
    # the foremost centre of the chair's discs is 0.539 m ahead of the axle
    assert found.h == pytest.approx(np.full((1, STEPS + 1), 5.0 - 0.9 - 0.539 - chair.capsule[4]))
    assert found.slack.tolist() == [0.0]
    assert found.smallest == found.h.min()
    # they come at 1 m/s: 0.2 m a step, each step takes 0.2 of h that is left, and h is 3.2 m
    coming = among([[[5.0, 1.0], [5.0, -1.0]]], velocity=(-1.0, 0.0))
    h = GroupBarrier().values(coming, motions.standing(coming)).h
    assert np.diff(h) == pytest.approx(np.full((1, STEPS), -0.2))


@pytest.mark.parametrize("heading", [0.0, 0.8, -2.5])
def test_no_group_is_farther_than_its_outline(heading, chair):
    """Sampled: the least distance between spine and polygon, which the hull lies in; to 2 %."""
    problem = among([[[1.6, 0.9], [2.4, -0.8], [3.0, 0.4]]], directions=64)
    groups = problem.spaces.groups
    pose = np.array([[-0.4, 0.3, heading]])
    normals = np.stack([np.cos(groups.direction), np.sin(groups.direction)], axis=-1)
    h = group_barrier(chair.capsule, pose, normals, groups.support[:, :1])[0, 0]
    cos, sin = np.cos(heading), np.sin(heading)
    turn = np.array([[cos, sin], [-sin, cos]])
    first, last = (pose[0, :2] + end @ turn for end in chair.capsule[:4].reshape(2, 2))
    spine = first + np.linspace(0.0, 1.0, 200)[:, None] * (last - first)
    outline = hull_outline(groups.direction, groups.support[0, 0])
    share = np.linspace(0.0, 1.0, 40)[:, None, None]
    edge = (outline[:-1] + share * np.diff(outline, axis=0)).reshape(-1, 2)
    sampled = np.hypot(*(spine[:, None] - edge).transpose(2, 0, 1)).min()
    assert h + chair.capsule[4] == pytest.approx(sampled, rel=0.02)
    told, _ = distance_to_hull(groups.direction, groups.support[0, 0], spine)
    assert h + chair.capsule[4] <= told.min() + 1e-12


def test_rows_are_derivatives(motions, rng):
    count = 0
    for _ in range(6):
        centres = rng.uniform([0.5, -2.0], [4.0, 2.0], (2, 3, 2))
        problem = among(centres, 0.7, velocity=rng.normal(0.0, 0.4, 2), speed=0.6)
        for other in (problem, motions.any_way(problem)):
            trajectory = motions.wandering(other, rng)
            rows = rows_at(other, trajectory, motions)

            def margins(m, other=other):
                found = rows_at(other, m, motions)
                out = np.full(found.num_row_ids, np.nan)
                out[found.row_id] = found.margin
                return out

            numeric = motions.slope(margins, other, trajectory)[rows.row_id]
            sound = np.isfinite(numeric).all(axis=1)
            assert np.abs(rows.jacobian[sound] - numeric[sound]).max() < 1e-6
            count += int(sound.sum())
    assert count > 60


def test_straight_between_two_who_talk_is_refused(motions):
    """Room enough for the chair between the two bodies, 2.4 m apart, and 1.2 m/s through it."""
    problem = among([[[2.5, 1.2], [2.5, -1.2]]], 0.7, speed=1.0)
    through = dataclasses.replace(
        motions.standing(problem), poses=np.linspace([0.0, 0.0, 0.0], [5.0, 0.0, 0.0], STEPS + 1)
    )
    found = GroupBarrier().values(problem, through)
    assert found.slack[0] > 0.5
    aside = dataclasses.replace(through, poses=through.poses + np.array([0.0, 3.5, 0.0]))
    assert GroupBarrier().values(problem, aside).slack[0] == 0.0


def test_who_is_within_a_group_is_asked_to_leave_and_may(motions):
    """Standing in the middle violates every row; going out by γ of the depth a step, none."""
    gamma = GroupBarrier().parameters.gamma
    problem = among([[[0.0, 3.0], [0.0, -3.0]]], 1.0)
    standing = motions.standing(problem)
    h = GroupBarrier().values(problem, standing).h[0, 0]
    assert h < -1.0
    assert GroupBarrier().values(problem, standing).slack[0] == pytest.approx(-gamma * h)
    # ahead is the shortest way out: 1.0 m and the rear of the spine
    way = -h * (1.0 - (1.0 - gamma) ** np.arange(STEPS + 1))
    poses = np.stack([way, np.zeros(STEPS + 1), np.zeros(STEPS + 1)], axis=-1)
    leaving = dataclasses.replace(standing, poses=poses)
    assert GroupBarrier().values(problem, leaving).slack[0] < 1e-9


def test_rows_within_a_group_lead_out_of_it(motions):
    problem = among([[[0.0, 3.0], [0.0, -3.0]]], 1.0)
    rows = rows_at(problem, motions.standing(problem), motions)
    speeding = np.tile([1.0, 0.0], STEPS)
    assert len(rows.margin) == STEPS
    assert (rows.jacobian @ speeding > 0.0).all()
    assert set(rows.slack_index.tolist()) == {0}


@pytest.mark.parametrize("groups", [None, "none of them", "far"])
def test_no_group_no_rows(groups, motions):
    problem = among([[[40.0, 1.0], [40.0, -1.0]]])
    if groups != "far":
        told = problem.spaces.groups
        none = dataclasses.replace(told, id=told.id[:0], support=told.support[:0])
        spaces = dataclasses.replace(problem.spaces, groups=none if groups else None)
        problem = dataclasses.replace(problem, spaces=spaces)
    trajectory = motions.standing(problem)
    assert not GroupBarrier().values(problem, trajectory).slack.any()
    assert rows_at(problem, trajectory, motions).jacobian.shape == (0, 2 * STEPS)


def test_the_world_may_be_turned_or_mirrored(chair, rng):
    problem = among([[[2.0, 1.0], [3.0, -0.5]], [[-1.0, 2.0], [0.5, 3.0]]])
    groups, poses = problem.spaces.groups, rng.normal(0.0, 1.0, (STEPS + 1, 3))

    def h(direction, support, poses):
        normals = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
        return group_barrier(chair.capsule, poses, normals, support)

    here = h(groups.direction, groups.support, poses)
    X = np.array([3.0, -2.0, 1.1])
    direction = groups.direction + X[2]
    moved = np.column_stack([transform(X, poses[:, :2]), poses[:, 2] + X[2]])
    shift = X[0] * np.cos(direction) + X[1] * np.sin(direction)
    assert h(direction, groups.support + shift, moved) == pytest.approx(here, abs=1e-9)
    flipped = poses * np.array([1.0, -1.0, -1.0])
    assert h(-groups.direction, groups.support, flipped) == pytest.approx(here, abs=1e-9)
