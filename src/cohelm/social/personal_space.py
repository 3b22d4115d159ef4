"""Personal space, eq. (5): an asymmetric Gaussian about each person, elongated along the motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.messages import Groups, People, Predictions, RiderProfile, SocialSpaces
from cohelm.shapes import KINDS, PRINTED, gaussian_deviations
from cohelm.social.group_space import group_spaces

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
        velocity = predictions.velocity
        speed = np.hypot(velocity[..., 0], velocity[..., 1])
        heading = people.heading[:, None, None]
        course = np.arctan2(velocity[..., 1], velocity[..., 0])
        axis = np.where(speed > p.axis_speed, course, heading)
        unknown = np.isnan(axis)
        front, side, rear = gaussian_deviations(speed)
        spaces = SocialSpaces(
            kind=KINDS[p.shape],
            scale=p.printed_scale if p.shape == "printed" else p.contour_scale,
            axis=np.where(unknown, 0.0, axis),
            front=front,
            side=np.where(unknown, front, side),
            rear=np.where(unknown | (p.shape == "ellipse"), front, rear),
            floor=profile.social_distance,
            robot=self._robot(twist),
        )
        hulls = group_spaces(people, groups, predictions, spaces, p.directions)
        return replace(spaces, groups=hulls)

    def _robot(self, twist: Floats) -> Floats:
        """(σ_h, σ_s, σ_r) of the robot; in reverse, the front is behind."""
        p = self.parameters
        front = float(gaussian_deviations(np.hypot(twist[0], twist[1]))[0])
        share = np.sqrt(p.robot_share) if KINDS[p.shape] == PRINTED else p.robot_share
        sigmas = share * front * np.array([1.0, 2.0 / 3.0, 0.5])
        return np.maximum(sigmas[::-1] if twist[0] < 0.0 else sigmas, _POINT)
