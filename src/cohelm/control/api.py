"""What a local planner is."""

from __future__ import annotations

from typing import Protocol

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.maps import DistanceField
from cohelm.messages import (
    Authority,
    LocalPlan,
    People,
    Predictions,
    Reference,
    RiderProfile,
    SocialSpaces,
)
from cohelm.robots import Robot


@value
class LocalProblem:
    """Everything a local planner may use."""

    time: float
    """Now, s."""
    robot: Robot
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    twist: Annotated[Floats, Shape("3")]
    """Robot frame."""
    reference: Reference
    """What to follow: the path and the rider's hand, blended."""
    people: People
    predictions: Predictions
    """Over the reference's steps."""
    spaces: SocialSpaces
    walls: DistanceField
    """Distance to all that is not a person: map and live obstacles, about the robot."""
    authority: Authority | None = None
    profile: RiderProfile = RiderProfile()
    speed_limit: float
    """m/s, of robot, rider and request together."""


class LocalPlanner(Protocol):
    """An entry point of ``cohelm.local_planners``; a class with ``Parameters``."""

    steps: int
    """N, the steps of the reference and the predictions it wants."""
    step: float
    """Time between them, s."""

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """A command and the plan behind it; ``previous`` is the memory. Never moves its arguments.

        Raises:
            ControlError: SolverFailed or Infeasible, with the problem.
        """
        ...
