"""Authority of the rider: from the stick to intent, from intent to η, and the shared reference.

Xu et al., eq. (13), prints η = 1 − eⁱ, which is never positive; it must be η = 1 − e⁻ⁱ: 0, 0.63,
0.86, 0.95 … for i = 0, 1, 2, 3. It never reaches 1: manual mode is separate.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, read_only, replace, value
from cohelm.config import Model
from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Observation, Reference, RiderProfile
from cohelm.robots import Robot

_ROUNDING = 1e-9  # s; times are sums of float steps
_CENTRED: Floats = read_only(np.zeros(2))
"""Deflection of a released stick."""
_TRAVELS = 0.05
"""Speed from which a chair travels forwards, m/s: odometry at rest is not exactly 0 (assumed)."""


class AuthorityParameters(Model):
    """Law of η and definition of an intent; the paper gives no figures, these are assumed."""

    count: Literal["intent", "messages"] = "intent"
    """``intent``: changes of the stick and the time it is held; ``messages``: every deflected
    message, as printed (a held stick sends 20 a second, so η is nearly 1 at once)."""
    window: float = Field(1.0, gt=0.0, le=10.0)
    """Time window in which intents are counted, s."""
    change: float = Field(0.3, gt=0.0, le=2.0)
    """Change of deflection that is an intent of its own, share of full deflection."""
    sustain: float = Field(0.25, gt=0.0, le=5.0)
    """Time after which a held stick is a further intent, s."""
    docking_distance: float = Field(1.5, ge=0.0, le=10.0)
    """Remaining distance from which η fades, down to 0 at the goal, m; 0: never."""
    stop_deflection: float = Field(0.5, gt=0.0, le=1.0)
    """Deflection against the direction of travel that requests a stop."""
    stop_time: float = Field(0.2, ge=0.0, le=5.0)
    """Time for which this deflection must be held, s."""


@value
class AuthorityState:
    """Memory of the sharing stage."""

    time: float
    filtered: Annotated[Floats, Shape("2")]
    """Deflection after the tremor filter."""
    intents: tuple[float, ...] = ()
    """Times of the intents within the window, s."""
    counted: Annotated[Floats, Shape("2")]
    """Deflection at the last intent."""
    against_since: float = math.inf
    """Time since which the stick is held against the travel, s."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class InputHorizon:
    """Steps of the predicted rider states."""

    steps: int
    """N."""
    step: float
    """Δt, s."""


def authority(
    observation: Observation,
    profile: RiderProfile,
    robot: Robot,
    *,
    horizon: InputHorizon,
    speed_limit: float,
    memory: AuthorityState | None,
    parameters: AuthorityParameters,
) -> tuple[Authority, AuthorityState]:
    """The rider's authority now; Xu et al., eq. (13), corrected.

    Args:
        observation: rider input, pose and twist; a rider without a device never deflects.
        profile: filter and dead zone.
        robot: full deflection requests its limits.
        horizon: steps of the rider's predicted states.
        speed_limit: speed of a full deflection where the robot can reach it, m/s.
        memory: result of the last call, None at first.
        parameters: law of η and definition of an intent.
    """
    now = observation.time
    raw = _CENTRED if observation.rider is None else observation.rider.deflection
    memory = memory or AuthorityState(time=now, filtered=raw, counted=_CENTRED)
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
        states=_rider_states(observation, twist, robot, horizon),
        wants_stop=now - since >= parameters.stop_time - _ROUNDING,
    )
    state = AuthorityState(
        time=now,
        filtered=filtered,
        intents=intents,
        counted=counted,
        against_since=since,
    )
    return out, state


def limit_authority(
    given: Authority, remaining: float, parameters: AuthorityParameters
) -> Authority:
    """The rider's authority, with η reduced near the goal.

    A rider who steers past a goal in a narrow place would leave the chair unable to turn back.

    Args:
        given: authority of the rider.
        remaining: distance to the goal along the path, m.
        parameters: with the ``docking_distance``.
    """
    remaining = max(remaining, 0.0)
    if remaining >= parameters.docking_distance:
        return given
    return replace(given, eta=given.eta * remaining / parameters.docking_distance)


def shared_reference(path: Reference, authority: Authority) -> Reference:
    """The shared reference x̂ = η x_user + (1 − η) x_global, Xu et al., eq. (12).

    Headings blend on the circle. With η = 0 it is the path's reference itself, bit for bit.
    """
    eta, rider = authority.eta, authority.states
    if eta == 0.0:
        return path
    poses = np.empty_like(path.poses)
    poses[:, :2] = eta * rider.poses[:, :2] + (1.0 - eta) * path.poses[:, :2]
    turn = wrap_angle(rider.poses[:, 2] - path.poses[:, 2])
    poses[:, 2] = path.poses[:, 2] + eta * np.unwrap(turn)
    return Reference(
        step=path.step,
        poses=poses,
        speeds=eta * rider.speeds + (1.0 - eta) * path.speeds,
    )


def stick_twist(stick: Floats, robot: Robot, speed_limit: float) -> Floats:
    """The twist (3,) that a deflection (forward, left) requests."""
    fastest = robot.max_speed if stick[0] > 0.0 else robot.max_reverse_speed
    top = min(fastest, speed_limit)
    twist = np.array([stick[0] * top, 0.0, stick[1] * robot.max_turn_rate])
    return robot.motion_model.twist(robot.motion_model.input(twist))


def _filtered(raw: Floats, memory: AuthorityState, now: float, time_constant: float) -> Floats:
    elapsed = max(now - memory.time, 0.0)
    if time_constant <= 0.0:
        return raw
    return memory.filtered + (1.0 - math.exp(-elapsed / time_constant)) * (raw - memory.filtered)


def _beyond_dead_zone(stick: Floats, dead_zone: float) -> Floats:
    """The deflection, rescaled so that it starts from 0 at the edge of the dead zone."""
    size = float(np.hypot(stick[0], stick[1]))
    if not size > dead_zone:
        return _CENTRED
    scaled = stick * ((size - dead_zone) / ((1.0 - dead_zone) * size))
    return np.minimum(np.maximum(scaled, -1.0), 1.0)


def _intents(
    stick: Floats, memory: AuthorityState, now: float, p: AuthorityParameters
) -> tuple[tuple[float, ...], Floats]:
    """(times of the intents in the window, deflection at the last of them)."""
    recent = tuple(t for t in memory.intents if now - t < p.window - _ROUNDING)
    if not stick.any():
        return recent, _CENTRED
    ahead, left = (stick - memory.counted).tolist()
    changed = float(np.hypot(ahead, left)) >= p.change
    first = not memory.counted.any()
    held = bool(recent) and now - recent[-1] >= p.sustain - _ROUNDING
    if p.count == "messages" or changed or first or held or not recent:
        return (*recent, now), stick
    return recent, memory.counted


def _against_since(
    stick: Floats, twist: Floats, memory: AuthorityState, now: float, p: AuthorityParameters
) -> float:
    """Start of the deflection against the travel, s; it lasts until release, even at standstill."""
    if not stick[0] <= -p.stop_deflection:
        return math.inf
    if math.isfinite(memory.against_since):
        return memory.against_since
    return now if twist[0] > _TRAVELS else math.inf


def _rider_states(
    observation: Observation, twist: Floats, robot: Robot, horizon: InputHorizon
) -> Reference:
    """Predicted states under the stick, from the present twist within the acceleration limits."""
    _, _, rise, fall = robot.input_bounds
    now, wanted = robot.motion_model.input(observation.twist), robot.motion_model.input(twist)
    times = _times(horizon.steps, horizon.step)
    change = np.minimum(np.maximum(wanted - now, -fall * times), rise * times)
    inputs = now + change
    poses = robot.motion_model.rollout(observation.pose, inputs, horizon.step)
    speeds = robot.motion_model.twist(inputs)[:, 0]
    return Reference(step=horizon.step, poses=poses, speeds=speeds[_held(horizon.steps)])


@functools.lru_cache(maxsize=8)
def _times(steps: int, step: float) -> Floats:
    """Times of the ends of the steps (N, 1), s."""
    return read_only((np.arange(steps) + 1.0)[:, None] * step)


@functools.lru_cache(maxsize=8)
def _held(steps: int) -> Integers:
    """Index of the step of each of N + 1 states; the last step also has the last state."""
    return read_only(np.minimum(np.arange(steps + 1), steps - 1))
