"""Motion to which the rider's stick leads over the horizon, with a destination or without one.

The forward deflection is a speed. The lateral deflection is a turn for a moment, followed by a
straight line: a rider who steers round a corner does not mean a circle. A stick without lateral
deflection keeps the direction that the chair had when the stick was straightened, turned as the
stick has turned it since. So a chair that was led round an obstacle returns to this direction.

The direction is the middle of an interval whose width grows with coarse or unsteady input
(``sharing.hand``). Within it, doors, passages and free space attract (``sharing.affordances``). A
stick that leans to one side closes the other side: the chair never turns back against it.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Observation, Reference
from cohelm.robots import Robot
from cohelm.sharing.affordances import Aim, aim, faces_passage, is_open
from cohelm.sharing.authority import InputHorizon, stick_twist
from cohelm.sharing.hand import COARSE, HandState, update_hand
from cohelm.sharing.intent import RiderIntent, SteeringParameters, SteeringState
from cohelm.sharing.passage_wait import Surroundings, waits_before

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


def rider_intent(
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
    memory = memory or SteeringState(time=observation.time, stick=authority.deflection)
    state, lean = _updated(observation, authority, robot, surroundings, memory, parameters)
    p, raw, stick, hand = parameters, authority.deflection, state.stick, state.hand
    heading = float(observation.pose[2])
    twist = stick_twist(np.array([max(stick[0], 0.0), stick[1]]), robot, speed_limit)
    # A switch says no more than "on": it is led wherever something attracts.
    own = state.aim if hand.kind == "one_switch" else state.heading
    off = float(wrap_angle(own - heading))  # NaN stays NaN
    inputs, reference = _motion(observation, robot, twist, off, horizon, p)
    if own is not state.aim:
        led = float(wrap_angle(state.aim - heading))
        _, reference = _motion(observation, robot, twist, led, horizon, p)
    intent = RiderIntent(
        inputs=inputs,
        reference=reference,
        speed=float(twist[0]),
        return_rate=_return_rate(off, robot.max_turn_rate) if abs(off) > _LED_ASIDE else 0.0,
        turn_share=_turn_share(observation, robot, surroundings, hand, state.turned_since, p),
        lean=lean,
        forward=bool(raw[0] > _FORWARD and stick[0] > _FORWARD),
        late_time=_late_time(hand, lean, p),
        clear_time=_clear_time(hand, p),
        wall_gap=p.wall_gap,
        squeezes=observation.time < state.squeezes_until,
        waits=raw[0] > _FORWARD and state.wait is not None and state.wait.stands,
    )
    return intent, state


def _updated(
    observation: Observation,
    authority: Authority,
    robot: Robot,
    surroundings: Surroundings | None,
    memory: SteeringState,
    p: SteeringParameters,
) -> tuple[SteeringState, int]:
    """(memory after the newest deflection, side to which the stick leans)."""
    raw = authority.deflection
    heading, elapsed = float(observation.pose[2]), observation.time - memory.time
    stick = _smoothed(raw, memory.stick, elapsed, p.smoothing)
    hand = _hand(observation, stick, elapsed, memory.hand, p)
    lean = _lean(raw, stick, hand, p)
    before = memory.heading + float(raw[1]) * robot.max_turn_rate * elapsed
    kept = _kept_heading(raw, stick, heading, before, elapsed, p)
    kept = _on_open_side(kept, heading, lean)
    aimed = _aimed(observation.pose, robot, surroundings, (kept, hand.width), memory.aim, p)
    pushed, until = _squeezing(observation, raw, memory, p)
    wait = waits_before(
        observation, float(authority.twist[0]), aimed.passage, surroundings, robot, memory.wait
    )
    state = SteeringState(
        time=observation.time,
        stick=stick,
        hand=hand,
        heading=kept,
        aim=_on_open_side(aimed.heading, heading, lean),
        turned_since=_turned_since(observation.time, raw, memory),
        pushed_since=pushed,
        squeezes_until=until,
        wait=wait,
    )
    return state, lean


def _hand(
    observation: Observation,
    stick: Floats,
    elapsed: float,
    memory: HandState,
    p: SteeringParameters,
) -> HandState:
    """Update the kind of input with the deflection that the device sent."""
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
    interval: tuple[float, float],
    last: float,
    p: SteeringParameters,
) -> Aim:
    """Heading that leads on within an interval, given as its middle and half its width, rad."""
    kept, width = interval[0], min(interval[1] * p.attraction, p.max_deviation)
    if surroundings is None or math.isnan(kept):
        return Aim(kept)
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
    """(inputs (N, m), reference) of a stick, towards a direction ``off`` rad to the left or NaN."""
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
