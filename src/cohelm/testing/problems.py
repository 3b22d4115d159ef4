"""Random local problems, drawn from a generator: a chair at speed, people about, up to two walls.

A wall is a half-plane (n_x, n_y, b): free where n·p > b, so that its distance is n·p − b. Bilinear
interpolation repeats a linear function exactly, so the distance field of one half-plane is exact
wherever it is sampled; that of two is exact but within a cell of the line where they are as near.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control.api import LocalProblem
from cohelm.geometry import compose, transform
from cohelm.maps import DistanceField
from cohelm.messages import Groups, People, Predictions, Reference, RiderProfile
from cohelm.robots import Robot, load_robot
from cohelm.social import PersonalSpace
from cohelm.testing.scenes import straight_on, walkers

WALLS = 2
"""Half-planes of every problem; some of them far away."""
_OUT_OF_SIGHT = np.array([1.0, 0.0, -1e3])
_REACH = 9.0
_RESOLUTION = 0.05


@value
class RandomProblem:
    """A problem, and the half-planes of its distance field."""

    problem: LocalProblem
    half_planes: Annotated[Floats, Shape("w 3")]


def random_problem(
    rng: np.random.Generator,
    people: int,
    *,
    steps: int = 25,
    step: float = 0.16,
    hopeless: bool = False,
) -> RandomProblem:
    """Draw a chair at up to 1 m/s along a straight or bent reference.

    Args:
        rng: source of all draws.
        people: number, within 8 m and at up to 1.4 m/s.
        steps, step: of reference and predictions.
        hopeless: people and walls may overlap the chair, and it may exceed its limits; otherwise
            it begins free of contact and within its limits.
    """
    robot = _chair()
    pose = np.array([*rng.uniform(-30.0, 30.0, 2), rng.uniform(-np.pi, np.pi)])
    top = 2.0 if hopeless else 1.0
    twist = np.array([rng.uniform(0.0, 1.0) * top, 0.0, rng.uniform(-0.6, 0.6) * top])
    planes = _half_planes(rng, robot, pose, -0.6 if hopeless else 0.1)
    who = _people(rng, robot, pose, people, -0.6 if hopeless else 0.1)
    return RandomProblem(
        problem=problem_of(
            robot=robot,
            pose=pose,
            twist=twist,
            reference=_reference(rng, pose, steps, step),
            people=who,
            walls=field_of(planes, pose),
        ),
        half_planes=planes,
    )


def problem_of(
    *,
    robot: Robot,
    pose: Floats,
    twist: Floats,
    reference: Reference,
    people: People,
    walls: DistanceField,
    time: float = 0.0,
    predictions: Predictions | None = None,
) -> LocalProblem:
    """Problem with the default personal space; by default people continue straight on."""
    profile = RiderProfile()
    if predictions is None:
        predictions = straight_on(people, len(reference.speeds) - 1, reference.step)
    return LocalProblem(
        time=time,
        robot=robot,
        pose=pose,
        twist=twist,
        reference=reference,
        people=people,
        predictions=predictions,
        spaces=PersonalSpace().spaces(
            people, Groups.alone(len(people)), predictions, twist, profile
        ),
        walls=walls,
        profile=profile,
        speed_limit=1.0,
    )


def field_of(half_planes: Floats, pose: Floats) -> DistanceField:
    """The distance field (18 m × 18 m about ``pose``) of half-planes (w, 3), turned like the pose.

    Cell centres lie half a cell from the field's corner, and hold the distance to the surface.
    """
    cells = round(2.0 * _REACH / _RESOLUTION)
    corner = transform(pose, np.full(2, -_REACH))
    X_MG = np.array([*corner, pose[2]])
    along = (np.arange(cells) + 0.5) * _RESOLUTION
    centres = transform(X_MG, np.stack(np.meshgrid(along, along), axis=-1))
    distance = (centres @ half_planes[:, :2].T - half_planes[:, 2]).min(axis=-1)
    return DistanceField(distance=distance.astype(np.float32), resolution=_RESOLUTION, X_MG=X_MG)


def turned(problem: LocalProblem, X: Floats) -> LocalProblem:
    """Problem in a world that was moved and turned by ``X``, (3,)."""
    reference, predictions = problem.reference, problem.predictions
    poses = reference.poses.copy()
    poses[:, :2] = transform(X, poses[:, :2])
    poses[:, 2] += X[2]
    pose = np.array([*transform(X, problem.pose[:2]), problem.pose[2] + X[2]])
    return dataclasses.replace(
        problem,
        pose=pose,
        reference=dataclasses.replace(reference, poses=poses),
        people=_moved_people(problem.people, X),
        predictions=dataclasses.replace(
            predictions,
            mean=transform(X, predictions.mean),
            velocity=_rotated(predictions.velocity, X[2]),
        ),
        spaces=dataclasses.replace(problem.spaces, axis=problem.spaces.axis + X[2]),
        walls=dataclasses.replace(problem.walls, X_MG=compose(X, problem.walls.X_MG)),
    )


def _moved_people(people: People, X: Floats) -> People:
    mean = np.hstack([transform(X, people.mean[:, :2]), _rotated(people.mean[:, 2:], X[2])])
    return dataclasses.replace(people, mean=mean, heading=people.heading + X[2])


def _rotated(vectors: Floats, angle: float) -> Floats:
    return transform(np.array([0.0, 0.0, angle]), vectors)


def mirrored(problem: LocalProblem) -> LocalProblem:
    """Problem with left and right exchanged: y and every angle change sign."""
    p, predictions, walls = problem.people, problem.predictions, problem.walls
    flip, side = np.array([1.0, -1.0, -1.0]), np.array([1.0, -1.0])
    # mirroring turns the grid's lower left corner into its upper left one
    corner = np.array([0.0, len(walls.distance) * walls.resolution])
    top = transform(walls.X_MG, corner) * side
    return dataclasses.replace(
        problem,
        pose=problem.pose * flip,
        twist=problem.twist * np.array([1.0, -1.0, -1.0]),
        reference=dataclasses.replace(problem.reference, poses=problem.reference.poses * flip),
        people=dataclasses.replace(p, mean=p.mean * np.tile(side, 2), heading=-p.heading),
        predictions=dataclasses.replace(
            predictions, mean=predictions.mean * side, velocity=predictions.velocity * side
        ),
        spaces=dataclasses.replace(problem.spaces, axis=-problem.spaces.axis),
        walls=dataclasses.replace(
            walls, distance=walls.distance[::-1], X_MG=np.array([*top, -walls.X_MG[2]])
        ),
    )


@functools.cache
def _chair() -> Robot:
    return load_robot("quantum_q6_edge")


def _reference(rng: np.random.Generator, pose: Floats, steps: int, step: float) -> Reference:
    """Arc that starts beside the chair, at a constant speed."""
    speed, bend = rng.uniform(0.4, 1.0), rng.uniform(-0.3, 0.3)
    start = compose(pose, np.array([0.0, rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4)]))
    heading = bend * speed * step * np.arange(steps + 1)
    ahead = speed * step * np.stack([np.cos(heading), np.sin(heading)], axis=-1)[:-1]
    points = np.vstack([np.zeros(2), np.cumsum(ahead, axis=0)])
    first = pose[2] + np.mod(start[2] - pose[2] + np.pi, 2.0 * np.pi) - np.pi
    poses = np.column_stack([transform(start, points), first + heading])
    return Reference(step=step, poses=poses, speeds=np.full(steps + 1, speed))


def _half_planes(rng: np.random.Generator, robot: Robot, pose: Floats, least_gap: float) -> Floats:
    """``WALLS`` half-planes at ``least_gap`` to 2.5 m from the footprint, each present or not."""
    out = np.tile(_OUT_OF_SIGHT, (WALLS, 1))
    centres = transform(pose, robot.discs[:, :2])
    for plane in out[: rng.integers(0, WALLS + 1)]:
        angle = rng.uniform(-np.pi, np.pi)
        plane[:2] = np.cos(angle), np.sin(angle)
        nearest = float((centres @ plane[:2] - robot.discs[:, 2]).min())
        plane[2] = nearest - rng.uniform(least_gap, 2.5)
    return out


def _people(
    rng: np.random.Generator, robot: Robot, pose: Floats, count: int, least_gap: float
) -> People:
    """People in front and about, ``least_gap`` or more from the footprint; every fifth stands."""
    states = np.empty((count, 4))
    radius = rng.uniform(0.2, 0.3, count)
    centres = transform(pose, robot.discs[:, :2])
    for i in range(count):
        gap = -np.inf
        while gap < least_gap:
            states[i, :2] = transform(pose, rng.uniform([-3.0, -5.0], [8.0, 5.0]))
            away = np.hypot(*(centres - states[i, :2]).T) - robot.discs[:, 2]
            gap = float(away.min()) - radius[i]
        course, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 1.4)
        states[i, 2:] = speed * np.cos(course), speed * np.sin(course)
        if rng.random() < 0.2:
            states[i, 2:] = 0.0
    return dataclasses.replace(walkers(states), radius=radius)
