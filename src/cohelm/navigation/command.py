"""Commands of rider or planner to the gate, and the problem of the local planner."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cohelm.arrays import Floats
from cohelm.control import LocalProblem
from cohelm.maps import DistanceField
from cohelm.messages import Authority, Reason, Reference, RiderProfile
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel

_TIGHT = 0.3
"""Gap to walls below which a place is tight, m; from twice as much on it is not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Command to the gate: a twist, or None and the reason to stop."""

    twist: Floats | None = None
    reason: Reason | None = None
    urgent: bool = False
    """Brake with maximum deceleration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowance:
    """Permissions of the local planner in this step."""

    speed_limit: float
    """m/s."""
    stalled: bool = False
    """Squeeze past people slowly."""
    reverses: bool = False
    max_deviation: float = math.inf
    """See ``LocalProblem.max_deviation``, rad."""
    rider_inputs: Floats | None = None
    """See ``LocalProblem.rider_inputs``."""


def tight_limit(step: StepInput, world: WorldModel) -> float:
    """Speed limit of the rider's profile in tight places, m/s; it fades with the distance."""
    slow = step.request.profile.tight_speed
    full = step.setup.speed_limit(step.request)
    if slow >= full:
        return math.inf
    gap = float(world.walls.at(step.observation.pose[:2])) - step.setup.robot.inscribed_radius
    share = min(max((gap - _TIGHT) / _TIGHT, 0.0), 1.0)
    return slow + share * (full - slow)


def local_problem(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    reference: Reference,
    allowance: Allowance,
    *,
    profile: RiderProfile,
    walls: DistanceField,
) -> LocalProblem:
    """Problem of the local planner in this step; a stalled chair creeps.

    Args:
        step: input of the step.
        world: people and their predictions.
        authority: of the rider.
        reference: to track.
        allowance: limits of this step.
        profile: of the rider, with the passing side.
        walls: distance to everything that is not a person.
    """
    setup, observation = step.setup, step.observation
    limit = min(setup.speed_limit(step.request), allowance.speed_limit)
    return LocalProblem(
        time=observation.time,
        robot=setup.robot,
        pose=observation.pose,
        twist=observation.twist,
        reference=reference,
        people=world.people,
        predictions=world.predictions,
        spaces=world.spaces,
        walls=walls,
        authority=authority,
        profile=profile,
        speed_limit=min(limit, setup.progress.creep_speed) if allowance.stalled else limit,
        stalled=allowance.stalled,
        reverses=allowance.reverses,
        extra_clearance=max(step.request.extra_clearance, 0.0),
        max_deviation=allowance.max_deviation,
        rider_inputs=allowance.rider_inputs,
        commanded=step.commanded,
        last_contact=world.last_contact,
        late=observation.late,
    )
