"""How much the rider steers: from the stick to intent, from intent to η.

Xu et al., eq. (13), prints η = 1 − eⁱ, which is never positive; it must be η = 1 − e⁻ⁱ: 0, 0.63,
0.86, 0.95 … for i = 0, 1, 2, 3. It never reaches 1: manual mode is separate.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.messages import Authority, Observation, Reference, RiderProfile
from cohelm.robots import Robot

_ROUNDING = 1e-9  # s; times are sums of float steps


class AuthorityParameters(Model):
    """What counts as an intent; the paper gives no figures, these are assumed."""

    count: Literal["intent", "messages"] = "intent"
    """``intent``: changes of the stick and time it is held; ``messages``: every deflected message,
    as printed (a held stick streams 20 a second, so η is at once nearly 1)."""
    frame: float = Field(1.0, gt=0.0, le=10.0)
    """The time frame in which intents are counted, s."""
    change: float = Field(0.3, gt=0.0, le=2.0)
    """A change of deflection that is an intent of its own, share of full deflection."""
    sustain: float = Field(0.25, gt=0.0, le=5.0)
    """A stick held for this long is a further intent, s."""
    docking: float = Field(1.5, ge=0.0, le=10.0)
    """Way left from which η fades, down to 0 at the goal, m; 0: never."""
    against: float = Field(0.5, gt=0.0, le=1.0)
    """Deflection against the travel that asks for a stop …"""
    against_time: float = Field(0.2, ge=0.0, le=5.0)
    """… once held for this long, s."""


@value
class AuthorityState:
    """What sharing remembers."""

    time: float
    filtered: Annotated[Floats, Shape("2")]
    """The stick after the tremor filter."""
    intents: tuple[float, ...] = ()
    """When the intents within the frame happened, s."""
    counted: Annotated[Floats, Shape("2")]
    """The deflection at the last intent."""
    against_since: float = math.inf
    """Since when the stick is held against the travel, s."""


def authority(
    observation: Observation,
    profile: RiderProfile,
    robot: Robot,
    *,
    steps: int,
    step: float,
    speed_limit: float,
    memory: AuthorityState | None,
    parameters: AuthorityParameters,
) -> tuple[Authority, AuthorityState]:
    """The rider's authority now; Xu et al., eq. (13), corrected.

    Args:
        observation: its rider, pose and twist; a rider without a device never deflects.
        profile: filter and dead zone.
        robot: whose limits a full deflection means.
        steps, step: N and Δt of the rider's states.
        speed_limit: m/s; a full deflection means this, where the robot can do as much.
        memory: of the last call, None at first.
        parameters: what counts as an intent.
    """
    now = observation.time
    raw = np.zeros(2) if observation.rider is None else observation.rider.deflection
    nothing = AuthorityState(time=now, filtered=raw, counted=np.zeros(2))
    memory = memory or nothing
    filtered = _filtered(raw, memory, now, profile.tremor_filter)
    stick = _beyond_dead_zone(filtered, profile.dead_zone)
    intents, counted = _intents(stick, memory, now, parameters)
    since = _against_since(stick, observation.twist, memory, now, parameters)
    twist = stick_twist(stick, robot, speed_limit)
    out = Authority(
        eta=1.0 - math.exp(-len(intents)),
        intent=float(len(intents)),
        deflection=stick,
        twist=twist,
        states=_rider_states(observation, twist, robot, steps, step),
        wants_stop=now - since >= parameters.against_time - _ROUNDING,
    )
    state = AuthorityState(
        time=now, filtered=filtered, intents=intents, counted=counted, against_since=since
    )
    return out, state


def docked(hand: Authority, left: float, parameters: AuthorityParameters) -> Authority:
    """The hand with what η is left to it at the end of the way.

    A hand that leads past the goal in a narrow place leaves a chair that cannot turn back to it.

    Args:
        hand: the rider's authority.
        left: way left, m.
        parameters: ``docking`` says from where η fades.
    """
    left = max(left, 0.0)
    if left >= parameters.docking:
        return hand
    return dataclasses.replace(hand, eta=hand.eta * left / parameters.docking)


def stick_twist(stick: Floats, robot: Robot, speed_limit: float) -> Floats:
    """The twist (3,) that a deflection (forward, left) asks for."""
    fastest = robot.max_speed if stick[0] > 0.0 else robot.max_reverse_speed
    top = min(fastest, speed_limit)
    twist = np.array([stick[0] * top, 0.0, stick[1] * robot.max_turn_rate])
    return robot.motion.twist(robot.motion.input(twist))


def _filtered(raw: Floats, memory: AuthorityState, now: float, time_constant: float) -> Floats:
    elapsed = max(now - memory.time, 0.0)
    if time_constant <= 0.0:
        return raw
    return memory.filtered + (1.0 - math.exp(-elapsed / time_constant)) * (raw - memory.filtered)


def _beyond_dead_zone(stick: Floats, dead_zone: float) -> Floats:
    """The deflection, rescaled so that it starts from 0 at the dead zone's edge."""
    size = float(np.hypot(*stick))
    if not size > dead_zone:
        return np.zeros(2)
    return np.clip(stick * ((size - dead_zone) / ((1.0 - dead_zone) * size)), -1.0, 1.0)


def _intents(
    stick: Floats, memory: AuthorityState, now: float, p: AuthorityParameters
) -> tuple[tuple[float, ...], Floats]:
    recent = tuple(t for t in memory.intents if now - t < p.frame - _ROUNDING)
    if not stick.any():
        return recent, np.zeros(2)
    changed = float(np.hypot(*(stick - memory.counted))) >= p.change
    first = not memory.counted.any()
    held = bool(recent) and now - recent[-1] >= p.sustain - _ROUNDING
    if p.count == "messages" or changed or first or held or not recent:
        return (*recent, now), stick
    return recent, memory.counted


def _against_since(
    stick: Floats, twist: Floats, memory: AuthorityState, now: float, p: AuthorityParameters
) -> float:
    """Once held against the travel it counts until it is let go, though the chair may stand."""
    back = stick[0] <= -p.against
    if not back:
        return math.inf
    if math.isfinite(memory.against_since):
        return memory.against_since
    return now if twist[0] > 0.0 else math.inf


def _rider_states(
    observation: Observation, twist: Floats, robot: Robot, steps: int, step: float
) -> Reference:
    """Where the stick would lead, from the present twist on within the robot's acceleration."""
    _, _, rise, fall = robot.input_bounds
    now, wanted = robot.motion.input(observation.twist), robot.motion.input(twist)
    times = (np.arange(steps) + 1.0)[:, None] * step
    inputs = now + np.clip(wanted - now, -fall * times, rise * times)
    poses = robot.motion.rollout(observation.pose, inputs, step)
    speeds = robot.motion.twist(inputs)[:, 0]
    return Reference(step=step, poses=poses, speeds=np.append(speeds, speeds[-1]))
