"""Parts of the state of the chair as pages get it in each step."""

from __future__ import annotations

from typing import Any

from cohelm.arrays import Floats
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import Notice, ReasonText
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.simulation import GroundTruth

SLOW_NOTICE = Notice(
    code="slow", text="This computer is too slow for real time; the simulation runs slower."
)
"""Notice of overload."""


def reason_text(decision: Decision, required: Reason | None) -> ReasonText | None:
    """Return the reason of a decision for the rider; None if nothing holds the chair.

    Args:
        decision: Decision at the wheels.
        required: Action that the driver must take first; None: nothing.
    """
    reason = decision.reason
    if reason is None or reason is Reason.ARRIVED:
        return None
    text = reason.sentence
    if reason is not Reason.STARTING and required not in {None, reason}:
        text = f"{text} {required.sentence}"
    return reason_of(reason, text)


def reason_of(reason: Reason, text: str) -> ReasonText:
    """Return a reason for the rider, with its text."""
    return ReasonText.model_construct(code=reason.value, text=text)


def true_people(truth: GroundTruth) -> tuple[tuple[float, float, float], ...]:
    """Return the ground truth of all people, (x, y, radius), m."""
    crowd = truth.crowd
    rows = zip(crowd.position.tolist(), crowd.radius.tolist(), crowd.there.tolist(), strict=True)
    return tuple((round(x, 3), round(y, 3), radius) for (x, y), radius, there in rows if there)


def rounded(pose: Floats) -> tuple[float, float, float]:
    """Round a pose to a millimetre and a milliradian."""
    x, y, heading = pose.tolist()
    return round(x, 3), round(y, 3), round(heading, 3)


def world_fields(world: LiveWorld | None) -> dict[str, Any]:
    """Return the fields of ``ChairState`` that come from the platform."""
    if world is None:
        return {"time": 0.0, "pose": (0.0, 0.0, 0.0), "speed": 0.0, "turn_rate": 0.0}
    observation, truth = world.observation, world.truth
    twist = observation.twist
    return {
        "time": round(observation.time if truth is None else truth.time, 3),
        "pose": rounded(observation.pose),
        "speed": round(float(twist[0]), 3),
        "turn_rate": round(float(twist[2]), 3),
        "true_people": true_people(truth) if truth is not None else (),
        "closed_doors": tuple(sorted(world.shut)),
    }
