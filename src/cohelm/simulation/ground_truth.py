"""Ground truth of a simulated ride; never visible to the navigator."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.messages import People
from cohelm.simulation.api import Crowd

STANDING_SPEED = 0.02
"""Speed below which the chair stands, m/s …"""
STANDING_TURN_RATE = 0.05
"""… if its turn rate is below this, rad/s."""


@value
class Touch:
    """Contact of the chair with a person or a wall, with measured forces."""

    time: float
    """Beginning, s."""
    person: int
    """Index of the person; −1: a wall or an object."""
    part: str
    """Part of the body, as ``thigh``; or ``wall``."""
    chair_part: str
    """Part of the chair."""
    force: float
    """Maximum force along the normal, N."""
    energy: float
    """Maximum energy in the compliance of the body part, J; 0 for a wall."""
    speed: float
    """Closing speed at the beginning, m/s."""
    chair_speed: float
    """Speed of the chair at the beginning, m/s."""


@value
class GroundTruth:
    """True state, and contacts since the last one; n people."""

    time: float
    """s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    twist: Annotated[Floats, Shape("3")]
    """Robot frame."""
    crowd: Crowd
    gap_people: Annotated[Floats, Shape("n")]
    """Gap between footprint and body, m; negative where they overlap, +inf for absent people."""
    gap_wall: float
    """Gap between footprint and nearest occupied cell, m; +inf without any."""
    hit_moving: Annotated[Booleans, Shape("n")]
    """Contact since the last state while the chair moved."""
    hit_standing: Annotated[Booleans, Shape("n")]
    """Contact since the last state while the chair stood."""
    hit_wall: bool
    """Contact with a wall since the last state."""
    fell: bool = False
    """A wheel has dropped over an edge since the last state."""
    touches: tuple[Touch, ...] = ()
    """Contacts that ended or lasted since the last state, where the world measures forces."""

    def as_people(self) -> People:
        """Return the present people as exact measurements."""
        crowd, index = self.crowd, np.flatnonzero(self.crowd.there)
        n = len(index)
        return People(
            time=self.time,
            id=index,
            mean=np.column_stack([crowd.position, crowd.velocity])[index],
            covariance=np.zeros((n, 4, 4)),
            heading=crowd.heading[index],
            radius=crowd.radius[index],
            confidence=np.ones(n),
            source="simulation",
        )


def is_standing(twist: Floats) -> Booleans:
    """Mask (...,) of twists (..., 3) that neither move nor turn."""
    moves = np.hypot(twist[..., 0], twist[..., 1]) >= STANDING_SPEED
    turns = np.abs(twist[..., 2]) >= STANDING_TURN_RATE
    still: Booleans = ~(moves | turns)
    return still
