"""Where the rider's stick leads over the horizon, with a destination or without one.

Forward is a speed. Aside is a turn that is meant for a moment, and then straight on: nobody who
steers round a corner means a circle. A stick without a turn means the direction that the chair had
when the stick was straightened, turned as the stick has turned it since, so that a chair that was
led round something comes back to it.

This direction is the middle of an interval, as wide as the hand is coarse or unsteady
(``sharing.hand``). Within it, what lies ahead attracts (``sharing.affordances``). A stick that leans
to one side closes the other one: the chair never turns back against it.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.geometry import wrap_angle
from cohelm.maps import DistanceField
from cohelm.messages import Authority, Observation, Reference
from cohelm.robots import Robot
from cohelm.sharing.affordances import aim, faces_passage, is_open
from cohelm.sharing.authority import InputHorizon, stick_twist
from cohelm.sharing.hand import COARSE, FREE_STICK, HandState, update_hand

_ROUNDING = 1e-9  # s; times are sums of float steps
_FORWARD = 0.02
"""Deflection above which the rider pushes forward, share of full."""
_PUSHED, _MOVES = 0.15, 0.05
"""A deflection above the first moves a free chair faster than the second; share of full, m/s."""
_RETURN_TIME = 1.0
"""Time in which the chair turns back to a kept direction, s."""
_RETURN_RATE = 0.6
"""Largest turn rate of doing so, share of the robot's."""
_LED_ASIDE = 0.06
"""Angle to the kept direction from which the chair was led aside, rad: less is noise."""
_FINE_SHARE, _FINE_TIME = 0.35, 0.7
"""Share of the turn rate with which a switch begins a turn near things, and its duration, s."""
_LONGEST_GAP = 0.5
"""Time between two calls up to which a direction is kept, s."""


class SteeringParameters(Model):
    """What a stick means, and how far the chair may differ from it; assumed."""

    smoothing: float = Field(0.25, ge=0.0, le=2.0)
    """Time constant of the low-pass on the stick, s."""
    turn_time: float = Field(0.8, ge=0.0, le=5.0)
    """Time for which a turn is meant, s."""
    turn_fade: float = Field(0.6, gt=0.0, le=5.0)
    """Time in which it then fades, s."""
    straight: float = Field(0.12, ge=0.0, le=1.0)
    """Lateral deflection up to which the direction is kept, share of full."""
    keep_time: float = Field(3.0, gt=0.0, le=60.0)
    """Time constant with which a kept direction gives way to that of the chair, s."""
    lean: float = Field(0.04, ge=0.0, le=1.0)
    """Angle of the stick from which it closes the other side, rad; its unsteadiness is added."""
    late_time: float = Field(0.8, gt=0.0, le=10.0)
    """A steady or leaning stick is overruled no more than keeps this time clear, s; twice the time
    for a coarse hand."""
    hand: Literal["auto", "stick", "eight_directions", "one_switch"] = "auto"
    """Hand on the stick; ``auto``: recognised by what it sends."""
    attraction: float = Field(1.0, ge=0.0, le=1.0)
    """Share of the width of the rider's direction in which doors, passages and free space attract;
    0: off."""
    reach: float = Field(4.0, gt=0.0, le=10.0)
    """Distance ahead that should be free, m."""
    max_deviation: float = Field(1.05, gt=0.0, le=3.2)
    """Largest angle between the motion of the chair and where the stick leads, rad."""
    clear_time: float = Field(3.0, gt=0.0, le=10.0)
    """The wheels follow the stick itself while this leads nowhere near anything, s; for things that
    stand this is the time of a coarse or unsteady hand …"""
    steady_clear_time: float = Field(0.8, gt=0.0, le=10.0)
    """… and this the one of a steady hand, which is taken at its word for longer, s; near means
    closer …"""
    wall_gap: float = Field(0.05, ge=0.0, le=0.5)
    """… than this to walls, m …"""
    people_gap: float = Field(0.15, ge=0.0, le=1.0)
    """… and this to people, m."""
    stuck_time: float = Field(1.0, gt=0.0, le=30.0)
    """Time of pushing without motion after which the chair squeezes through, s …"""
    squeeze_time: float = Field(4.0, ge=0.0, le=60.0)
    """… for this time, slowly and closer to people and walls than otherwise, s."""


@value
class SteeringState:
    """Memory of the rider's intent."""

    time: float
    """s."""
    stick: Annotated[Floats, Shape("2")]
    """Deflection after the low-pass."""
    hand: HandState = FREE_STICK
    """With the width of the rider's direction."""
    heading: float = math.nan
    """Direction in the map that a straight stick keeps, rad; NaN: none."""
    aim: float = math.nan
    """Heading within the interval about it that the chair is led to, rad; NaN: none."""
    turned_since: float = math.inf
    """Time since which the stick turns the chair on the spot, s."""
    pushed_since: float = math.inf
    """Time since which a push has moved nothing, s."""
    squeezes_until: float = -math.inf
    """s."""


@value
class RiderIntent:
    """Motion that the rider's stick asks for."""

    inputs: Annotated[Floats, Shape("N m")]
    """Inputs of the rider's own motion."""
    reference: Reference
    """Poses and speeds, N + 1 each, of the motion that is led to what lies ahead."""
    speed: float
    """Speed of the stick, m/s."""
    return_rate: float
    """Turn rate back to the direction of the push for a chair that was led aside, rad/s."""
    turn_share: float
    """Share of the turn rate of a turn on the spot: less where a switch begins one."""
    lean: int
    """Side to which the stick leans: 1 left, −1 right, 0 neither."""
    forward: bool
    """The rider pushes forward; otherwise the chair turns on the spot, backs up or stands."""
    late_time: float
    """The stick is overruled no more than keeps this time clear, s; 0: no such limit."""
    clear_time: float
    """The rider's own motion is taken while no thing that stands is closer than this, s."""
    squeezes: bool
    """A push has moved nothing for a while."""


@value
class Surroundings:
    """Things about the chair that do not walk."""

    walls: DistanceField
    """Of map and live obstacles."""
    standing: Annotated[Floats, Shape("n 3")]
    """People who stand, as x, y and radius, m."""


def rider_intent(  # noqa: PLR0913  # the stick, and all that it is read with
    observation: Observation,
    authority: Authority,
    robot: Robot,
    *,
    horizon: InputHorizon,
    speed_limit: float,
    surroundings: Surroundings | None = None,
    memory: SteeringState | None,
    parameters: SteeringParameters,
) -> tuple[RiderIntent, SteeringState]:
    """The motion that the stick asks for now.

    Args:
        observation: time, pose, twist and the deflection as the device sent it.
        authority: the rider's, with the deflection.
        robot: full deflection requests its limits.
        horizon: steps of the reference.
        speed_limit: speed of a full deflection where the robot can reach it, m/s.
        surroundings: what may attract; None: nothing does.
        memory: result of the last call, None at first.
        parameters: what a stick means.
    """
    p, raw, heading = parameters, authority.deflection, float(observation.pose[2])
    memory = memory or SteeringState(time=observation.time, stick=raw)
    elapsed = observation.time - memory.time
    stick = _smoothed(raw, memory.stick, elapsed, p.smoothing)
    hand = _hand(observation, stick, elapsed, memory.hand, p)
    lean = _lean(raw, stick, hand, p)
    turn = float(raw[1]) * robot.max_turn_rate
    kept = _kept_heading(raw, stick, heading, memory.heading + turn * elapsed, elapsed, p)
    kept = _on_open_side(kept, heading, lean)
    aimed = _aimed(observation.pose, robot, surroundings, kept, hand.width, memory.aim, p)
    aimed = _on_open_side(aimed, heading, lean)
    turned_since = _turned_since(observation.time, raw, memory)
    pushed, until = _squeezing(observation, raw, memory, p)
    twist = stick_twist(np.array([max(stick[0], 0.0), stick[1]]), robot, speed_limit)
    # A switch says no more than "on": it is led wherever something attracts.
    own = aimed if hand.kind == "one_switch" else kept
    off = float(wrap_angle(own - heading))  # NaN stays NaN
    inputs, _ = _motion(observation, robot, twist, off, horizon, p)
    _, reference = _motion(
        observation, robot, twist, float(wrap_angle(aimed - heading)), horizon, p
    )
    rate = _return_rate(off, robot.max_turn_rate) if abs(off) > _LED_ASIDE else 0.0
    intent = RiderIntent(
        inputs=inputs,
        reference=reference,
        speed=float(twist[0]),
        return_rate=rate,
        turn_share=_turn_share(observation, robot, surroundings, hand, turned_since, p),
        lean=lean,
        forward=bool(raw[0] > _FORWARD and stick[0] > _FORWARD),
        late_time=_late_time(hand, lean, p),
        clear_time=_clear_time(hand, p),
        squeezes=observation.time < until,
    )
    state = SteeringState(
        time=observation.time,
        stick=stick,
        hand=hand,
        heading=kept,
        aim=aimed,
        turned_since=turned_since,
        pushed_since=pushed,
        squeezes_until=until,
    )
    return intent, state


def _hand(
    observation: Observation,
    stick: Floats,
    elapsed: float,
    memory: HandState,
    p: SteeringParameters,
) -> HandState:
    """Update the hand by the deflection that the device sent."""
    sent = np.zeros(2) if observation.rider is None else observation.rider.deflection
    given = None if p.hand == "auto" else p.hand
    return update_hand(sent, stick, elapsed, memory, given=given)


def _lean(raw: Floats, stick: Floats, hand: HandState, p: SteeringParameters) -> int:
    """Side to which a stick leans by more than its unsteadiness."""
    if not raw[0] > 0.0 or raw[1] * stick[1] <= 0.0:
        return 0
    angle = math.atan2(abs(float(stick[1])), max(float(stick[0]), 0.0))
    noise = hand.unsteadiness if hand.kind == "stick" else 0.0
    return int(np.sign(raw[1])) if angle > p.lean + noise else 0


def _clear_time(hand: HandState, p: SteeringParameters) -> float:
    """Time for which the rider's own motion must be clear of things that stand, s."""
    coarse = min(hand.width / COARSE, 1.0)
    steady = min(p.steady_clear_time, p.clear_time)
    return steady + coarse * (p.clear_time - steady)


def _late_time(hand: HandState, lean: int, p: SteeringParameters) -> float:
    """Time that the chair keeps clear by turning otherwise than the stick, s."""
    if lean:
        return p.late_time
    # A switch that is held says "on", and leaves the direction to the chair.
    return 0.0 if hand.kind == "one_switch" else p.late_time * (1.0 + hand.width / COARSE)


def _on_open_side(direction: float, heading: float, lean: int) -> float:
    """Direction, or the heading now where the stick leans to the other side, rad."""
    return heading if lean * float(wrap_angle(direction - heading)) < 0.0 else direction


def _aimed(
    pose: Floats,
    robot: Robot,
    surroundings: Surroundings | None,
    kept: float,
    width: float,
    last: float,
    p: SteeringParameters,
) -> float:
    """Heading that leads on within the interval about the kept direction, rad."""
    width = min(width * p.attraction, p.max_deviation)
    if surroundings is None or math.isnan(kept):
        return kept
    return aim(
        pose,
        surroundings.walls,
        robot,
        centre=kept,
        width=width,
        reach=p.reach,
        last=last,
        standing=surroundings.standing,
    )


def _turned_since(now: float, raw: Floats, memory: SteeringState) -> float:
    """Time since which the stick turns the chair on the spot, s; +inf: it does not."""
    if raw[1] == 0.0 or abs(float(raw[0])) > _FORWARD:
        return math.inf
    return min(memory.turned_since, now)


def _turn_share(
    observation: Observation,
    robot: Robot,
    surroundings: Surroundings | None,
    hand: HandState,
    since: float,
    p: SteeringParameters,
) -> float:
    """Share of a turn on the spot.

    Between the wish to stop and a switch that is released lie some tenths of a second, so that
    a turn at full rate cannot be small. Where something is near, it begins slowly, and it is slow
    past a door or a passage, so that it ends there.
    """
    if hand.kind != "one_switch" or math.isinf(since) or surroundings is None:
        return 1.0
    pose, walls, standing = observation.pose, surroundings.walls, surroundings.standing
    if p.attraction <= 0.0 or is_open(pose, walls, robot, standing):
        return 1.0
    if faces_passage(pose, walls, robot, p.reach, standing):
        return _FINE_SHARE
    over = (observation.time - since - _FINE_TIME) / _FINE_TIME
    return min(max(_FINE_SHARE + (1.0 - _FINE_SHARE) * over, _FINE_SHARE), 1.0)


def _motion(
    observation: Observation,
    robot: Robot,
    twist: Floats,
    off: float,
    horizon: InputHorizon,
    p: SteeringParameters,
) -> tuple[Floats, Reference]:
    """(inputs (N, m), reference) of a stick, towards a direction ``off`` rad to the left, if any."""
    # states are half a step into each input, so that the rollout ends where the input ends
    times = np.asarray((np.arange(horizon.steps) + 0.5) * horizon.step, dtype=float)
    back = _return_rate(off, robot.max_turn_rate)
    turns = _turn_rates(float(twist[2]), off, back, times, p)
    inputs = _reachable(observation.twist, twist, turns, times, robot)
    speeds = robot.motion_model.twist(inputs)[:, 0]
    reference = Reference(
        step=horizon.step,
        poses=robot.motion_model.rollout(observation.pose, inputs, horizon.step),
        speeds=np.append(speeds, speeds[-1]),
    )
    return inputs, reference


def _smoothed(raw: Floats, last: Floats, elapsed: float, time_constant: float) -> Floats:
    """Deflection after a low-pass; a released stick is released at once."""
    if not raw.any():
        return np.zeros(2)
    if time_constant <= 0.0:
        return raw
    share = 1.0 - math.exp(-max(elapsed, 0.0) / time_constant)
    smoothed: Floats = last + share * (raw - last)
    return smoothed


def _kept_heading(
    raw: Floats, stick: Floats, heading: float, kept: float, elapsed: float, p: SteeringParameters
) -> float:
    """Direction that a straight stick keeps, rad; NaN if the rider turns or has let go."""
    if not raw.any() or abs(float(stick[1])) >= p.straight:
        return math.nan
    if math.isnan(kept) or not 0.0 <= elapsed <= _LONGEST_GAP:
        return heading
    off = float(wrap_angle(kept - heading)) * math.exp(-elapsed / p.keep_time)
    return heading + min(max(off, -p.max_deviation), p.max_deviation)


def _squeezing(
    observation: Observation, raw: Floats, memory: SteeringState, p: SteeringParameters
) -> tuple[float, float]:
    """(time since which a push has moved nothing, time until which the chair squeezes), s."""
    if not raw[0] > _PUSHED:
        return math.inf, -math.inf
    now, moves = observation.time, abs(float(observation.twist[0])) > _MOVES
    since = math.inf if moves else min(memory.pushed_since, now)
    stuck = now - since >= p.stuck_time - _ROUNDING
    return since, now + p.squeeze_time if stuck else memory.squeezes_until


def _return_rate(off: float, limit: float) -> float:
    """Turn rate back to a kept direction, rad/s; ``limit`` is that of the robot."""
    if math.isnan(off):
        return 0.0
    return math.copysign(min(abs(off) / _RETURN_TIME, _RETURN_RATE * limit), off)


def _turn_rates(
    asked: float, off: float, rate: float, times: Floats, p: SteeringParameters
) -> Floats:
    """Turn rates (N,) of the stick: for a while, or back to the kept direction, rad/s.

    Args:
        asked: turn rate of the stick, rad/s.
        off: angle to the kept direction, rad; NaN: none is kept.
        rate: turn rate back to it, rad/s.
        times: of the steps (N,), s.
        p: parameters.
    """
    if math.isnan(off):
        rates: Floats = asked * np.clip(1.0 - (times - p.turn_time) / p.turn_fade, 0.0, 1.0)
        return rates
    lasts = abs(off) / abs(rate) if rate else 0.0
    return np.where(times < lasts, rate, 0.0)


def _reachable(now: Floats, asked: Floats, turns: Floats, times: Floats, robot: Robot) -> Floats:
    """Inputs (N, m) from the present twist towards the asked one, within the accelerations."""
    _, _, rise, fall = robot.input_bounds
    wanted = np.tile(asked, (len(times), 1))
    wanted[:, 2] = turns
    model = robot.motion_model
    start, wanted = model.input(now), model.input(wanted)
    steps = times[:, None]
    inputs: Floats = start + np.minimum(np.maximum(wanted - start, -fall * steps), rise * steps)
    return inputs
