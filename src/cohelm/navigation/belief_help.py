"""Destinations of a rider in the pipeline: the belief, the way there, and the helped authority."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import Authority, DestinationBelief
from cohelm.navigation.destination_inference import DestinationInference, DestinationState
from cohelm.navigation.tick import StepInput
from cohelm.sharing import helped_deflection, stick_twist

_ANGLES = np.linspace(-1.0, 1.0, 11)
"""Angles to the chair's heading in which the way is looked for, rad."""
_AHEAD = 1.5
"""Distance at which it is looked for, m."""


def inferred_destinations(
    inference: DestinationInference | None, step: StepInput, authority: Authority
) -> tuple[DestinationBelief | None, DestinationState | None]:
    """Infer destinations while the rider has chosen none; also return the memory.

    Args:
        inference: of the map; None: it has no named places.
        step: input of the step.
        authority: of the rider.
    """
    if inference is None or not np.isnan(step.request.goal).any():
        return None, None
    return inference.update(
        step.observation.time,
        step.observation.pose,
        authority.deflection,
        step.setup.robot.max_turn_rate,
        step.memory.destinations,
    )


def with_belief_help(
    step: StepInput,
    inference: DestinationInference | None,
    belief: DestinationBelief | None,
    authority: Authority,
) -> Authority:
    """The authority with the turn towards the believed place; the rider's own without help.

    Args:
        step: input of the step.
        inference: of the map, with the cost-to-go of its places.
        belief: now; None with a destination.
        authority: of the rider.
    """
    setup, pose = step.setup, step.observation.pose
    p = setup.destinations.help
    if not p.use or inference is None or belief is None or not len(belief.places):
        return authority
    place = int(np.argmax(belief.places))
    certainty = float(belief.places[place])
    if certainty <= p.begin:
        return authority
    angle = _way(inference, pose, place)
    deflection = helped_deflection(authority.deflection, certainty, angle, p)
    if deflection is authority.deflection:
        return authority
    twist = stick_twist(deflection, setup.robot, setup.speed_limit(step.request))
    return dataclasses.replace(authority, deflection=deflection, twist=twist)


def _way(inference: DestinationInference, pose: Floats, place: int) -> float:
    """Angle from the heading to the direction in which the cost-to-go falls most, rad."""
    ends = [inference.fields.reached(pose[:2], pose[2] + a, _AHEAD) for a in _ANGLES]
    cost = [float(inference.fields.at(end)[place]) for end in ends]
    return float(_ANGLES[int(np.argmin(cost))])
