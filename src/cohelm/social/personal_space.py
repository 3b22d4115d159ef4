"""Personal space, eq. (5): an asymmetric Gaussian about each person, elongated along the motion.

The space of a group is the convex hull of its members' spaces over the horizon.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers, read_only, sealed, unchecked
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.messages import Groups, GroupSpaces, People, Predictions, RiderProfile, SocialSpaces
from cohelm.shapes import KINDS, PRINTED, RadialShape, gaussian_deviations, support


class _Members(NamedTuple):
    """Spaces of n people in h hypotheses over N + 1 steps."""

    group: Integers
    """(n,) −1: alone."""
    weight: Floats
    """(n, h) probabilities."""
    position: Floats
    """(n, h, N+1, 2) m."""
    axis: Floats
    """(n, h, N+1) rad."""
    front: Floats
    side: Floats
    rear: Floats
    radius: Floats
    """(n,) m."""


def group_spaces(
    people: People,
    groups: Groups,
    predictions: Predictions,
    spaces: SocialSpaces,
    directions: int = 32,
) -> GroupSpaces:
    """Compute the hull of each group's personal spaces at every step.

    The support of a hull is the maximum of its members'. Each person follows their most likely
    hypothesis: a hull of all hypotheses would block the floor around a group that only stands
    there. A personal space is grown by the body, as between the chair and one person.

    Args:
        people: n people.
        groups: of these people.
        predictions: of their motion.
        spaces: of each person.
        directions: number of normals; the outline is too large by at most
            1 / cos(π / directions) − 1 of its radius of curvature, 0.5 % with 32.
    """
    direction, cos, sin = _normals(directions)
    members = _Members(
        groups.member,
        predictions.weight,
        predictions.mean,
        spaces.axis,
        spaces.front,
        spaces.side,
        spaces.rear,
        people.radius,
    )
    form = (spaces.kind, spaces.scale, spaces.floor)
    found = _supports(members, len(groups.id), form, cos, sin)
    found.flags.writeable = False
    return GroupSpaces(id=groups.id, direction=direction, support=found)


@lru_cache(maxsize=8)
def _normals(directions: int) -> tuple[Floats, Floats, Floats]:
    """(angle, rad, its cosine, its sine) of evenly spaced directions, (m,) each."""
    angle = 2.0 * np.pi * np.arange(directions) / directions
    return read_only(angle), read_only(np.cos(angle)), read_only(np.sin(angle))


@njit(**CACHED)
def _supports(
    members: _Members, count: int, form: tuple[int, float, float], cos: Floats, sin: Floats
) -> Floats:
    """Maximum of p·u (count, N+1, m) over the members' grown spaces; u = (cos, sin), (m,).

    form: (kind, scale, floor) of all shapes.
    """
    kind, scale, floor = form
    steps, m = members.position.shape[2], cos.shape[0]
    out = np.full((count, steps, m), -np.inf)
    for i in range(members.group.shape[0]):
        if members.group[i] < 0:
            continue
        best, radius, h = out[members.group[i]], members.radius[i], members.weight[i].argmax()
        for k in range(steps):
            x, y = members.position[i, h, k, 0], members.position[i, h, k, 1]
            ahead, aside = np.cos(members.axis[i, h, k]), np.sin(members.axis[i, h, k])
            sigmas = members.front[i, h, k], members.side[i, h, k], members.rear[i, h, k]
            shape = RadialShape(kind, sigmas[0], sigmas[1], sigmas[2], scale, floor)
            for j in range(m):
                far = support(
                    shape, ahead * cos[j] + aside * sin[j], ahead * sin[j] - aside * cos[j]
                )
                best[k, j] = max(best[k, j], x * cos[j] + y * sin[j] + far + radius)
    return out


_POINT = 1e-3
"""σ of a disabled space, m: no extent, and no division by zero."""


class PersonalSpace:
    """Xu et al., eq. (5): σ_h = max(1/2, 2|v|), σ_s = 2/3 σ_h, σ_r = 1/2 σ_h along the motion.

    |v| is the predicted speed at each step. The axis is the direction of motion, or the last
    heading of a person (nearly) at rest; an unknown heading gives a circle of σ_h. The robot's own
    space has the same proportions at its measured speed, reduced to ``robot_share`` of the extent.
    A group's space is the convex hull of its members'.
    """

    class Parameters(Model):
        """Parameters of the model; assumed where no source is named."""

        shape: Literal["contour", "printed", "ellipse"] = "contour"
        """``contour``: l = √(c/q), convex. ``printed``: l = c/q, as in the paper. ``ellipse``: the
        smallest ellipse about the contour, with equal extent behind and ahead."""
        contour_scale: float = Field(0.125, gt=0.0, le=10.0)
        """c of contour and ellipse, without unit: ahead l = σ_h √(2c) = |v| · 1 s, so 1.2 m at
        1.2 m/s (Hall's personal distance), 0.8 m aside and 0.6 m behind the contour."""
        printed_scale: float = Field(0.104, gt=0.0, le=10.0)
        """c as printed, 1/m: ahead l = 2 c σ_h², the same 1.2 m at 1.2 m/s."""
        axis_speed: float = Field(0.2, ge=0.0, le=3.0)
        """Least speed at which the axis follows the predicted motion, m/s."""
        robot_share: float = Field(0.25, ge=0.0, le=1.0)
        """Extent of the robot's own space as a share of a person's at that speed; 0: none. Eq. (8)
        subtracts both from the distance: with much more, no corridor is wide enough."""
        directions: int = Field(32, ge=8, le=360)
        """Number of normals of a group's hull."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def spaces(
        self,
        people: People,
        groups: Groups,
        predictions: Predictions,
        twist: Floats,
        profile: RiderProfile,
    ) -> SocialSpaces:
        """See :meth:`SocialModel.spaces`."""
        p = self.parameters
        shapes = _shapes(people.heading, predictions.velocity, p.axis_speed, p.shape == "ellipse")
        spaces = SocialSpaces(
            kind=KINDS[p.shape],
            scale=p.printed_scale if p.shape == "printed" else p.contour_scale,
            floor=profile.social_distance,
            robot=self._robot(twist),
            **sealed(shapes)._asdict(),
        )
        hulls = group_spaces(people, groups, predictions, spaces, p.directions)
        return unchecked(spaces, groups=hulls)

    def _robot(self, twist: Floats) -> Floats:
        """(σ_h, σ_s, σ_r) of the robot; in reverse, the front is behind."""
        p = self.parameters
        front = gaussian_deviations(float(np.hypot(twist[0], twist[1])))[0]
        share = math.sqrt(p.robot_share) if KINDS[p.shape] == PRINTED else p.robot_share
        sigmas = [max(share * front * each, _POINT) for each in (1.0, 2.0 / 3.0, 0.5)]
        return np.array(sigmas[::-1] if twist[0] < 0.0 else sigmas)


class _Shapes(NamedTuple):
    """Shapes of n people in h hypotheses at N + 1 steps: columns of ``SocialSpaces``."""

    axis: Floats
    front: Floats
    side: Floats
    rear: Floats


@njit(**CACHED)
def _shapes(heading: Floats, velocity: Floats, axis_speed: float, symmetric: bool) -> _Shapes:
    """Axes, rad, and deviations of eq. (5), m, (n, h, N+1) each.

    Args:
        heading: (n,) rad; NaN where unknown, which gives a circle at rest.
        velocity: (n, h, N+1, 2) m/s.
        axis_speed: least speed at which the axis follows the motion, m/s.
        symmetric: True for equal extent behind and ahead.
    """
    n, h, steps = velocity.shape[:3]
    out = _Shapes(
        np.empty((n, h, steps)),
        np.empty((n, h, steps)),
        np.empty((n, h, steps)),
        np.empty((n, h, steps)),
    )
    for i in range(n):
        for j in range(h):
            for k in range(steps):
                vx, vy = velocity[i, j, k, 0], velocity[i, j, k, 1]
                speed = math.hypot(vx, vy)
                axis = math.atan2(vy, vx) if speed > axis_speed else heading[i]
                front, side, rear = gaussian_deviations(speed)
                if math.isnan(axis):
                    axis, side, rear = 0.0, front, front
                out.axis[i, j, k], out.front[i, j, k] = axis, front
                out.side[i, j, k], out.rear[i, j, k] = side, front if symmetric else rear
    return out
