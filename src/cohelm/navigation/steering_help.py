"""Steering help: the rider's own motion where it is clear, else the nearest clear one.

1. Before a narrow passage the chair waits for people who come towards it.
2. Without a forward push the safety gate gets the rider's motion: the chair turns on the spot,
   backs up or stands. It turns slowly beside an obstacle; a single switch also turns slowly at
   first.
3. A motion that is clear of walls and people is not changed, except that a chair that was led aside
   turns back to the direction of the push. Clear means for 0.8 s with a steady stick, and for 3 s
   with a coarse or unsteady one.
   A wall of the map that the scan passes stops the chair, but does not turn it
   (``navigation.map_openings``).
   A chair that squeezes past something skips this step and the next.
4. Where only walking people are in the way, the chair keeps the rider's motion at a lower speed. A
   chair that yields takes step 5 at once.
5. Otherwise the local planner tracks the motion that the stick asks for: it slides along walls,
   passes people and obstacles, and goes through doors. It is never faster than the stick asks, and
   never farther from its direction than ``SteeringParameters.max_deviation``.
   A steady stick, or one that leans to a side, is not overruled for what lies farther ahead: the
   chair takes only as much of the planned turn as keeps it clear for a moment.
6. If the planner finds nothing, the rider's motion is tried at creep speed, which no corner of the
   chair exceeds. The gate decides, and gives the reason.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.errors import ControlError
from cohelm.messages import Authority, Decision, LocalPlan, Reason
from cohelm.navigation.command import Allowance, Command, local_problem
from cohelm.navigation.standstill import is_standing_still
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.robots.contact import contact_times
from cohelm.robots.contact_kernel import ContactMargins
from cohelm.sharing import (
    InputHorizon,
    RiderIntent,
    SteeringState,
    Surroundings,
    rider_intent,
    with_literal_stick,
)

_SHARES = (0.75, 0.5, 0.25, 0.0)
"""Shares of the rider's speed at which people who walk may pass."""
_CHANGES = (0.0, 0.25, 0.5, 0.75)
"""Shares of the change of the turn rate that the local planner proposes."""
_SWEPT_TIME, _BESIDE_WALL = 0.8, 0.35
"""A turn on the spot that meets a wall within this time, s, keeps this share of its rate."""
_SOON, _PEOPLE_GAP = 0.5, 0.05
"""Time for which a motion at creep speed must keep clear of people, s, and the gap, m."""
_SLOWEST = 0.1
"""Speed that the planner may always use, m/s."""


def intent_of(
    step: StepInput, world: WorldModel, authority: Authority
) -> tuple[RiderIntent, SteeringState]:
    """Motion that the rider's stick asks for in this step; also return the memory."""
    parameters = step.setup.steering
    if authority.yields:
        parameters = with_literal_stick(parameters, step.setup.yielding)
    setup, people = step.setup, world.people
    walks = np.hypot(*people.mean[:, 2:].T) >= setup.recovery.walking_speed
    standing = np.column_stack([people.mean[~walks, :2], people.radius[~walks]])
    return rider_intent(
        step.observation,
        authority,
        setup.robot,
        horizon=InputHorizon(steps=setup.local_planner.steps, step=setup.local_planner.step),
        speed_limit=setup.speed_limit(step.request),
        surroundings=Surroundings(walls=world.walls, standing=standing, walking=people.mean[walks]),
        memory=step.memory.steering,
        parameters=parameters,
    )


def steer(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    intent: RiderIntent,
    previous: LocalPlan | None,
    gate: Callable[[Floats], Decision],
) -> tuple[LocalPlan | None, Command]:
    """Compute the command of a rider who is helped with steering.

    Args:
        step: input of the step.
        world: people and obstacles.
        authority: of the rider, with the twist that the stick asks for.
        intent: where that leads.
        previous: plan of the last tick, if any.
        gate: decision on a twist (3,).

    Returns:
        The plan, None where the rider's own motion is taken, and the command for the gate.
    """
    twist = authority.twist
    if intent.waits or not intent.forward:
        return None, _waiting_or_without_push(step, world, intent, twist)
    own = None if intent.squeezes else _own_motion(step, world, authority, intent)
    if own is not None:
        return None, own
    try:
        plan = _planned_motion(step, world, authority, intent, previous)
    except ControlError:
        return None, Command(reason=Reason.SOLVER_FAILED)
    instead = _creep(step, world, twist, plan, gate) or _with_less_turn(
        step, world, twist, plan, intent
    )
    if instead is not None:
        return None, instead
    reported = None if plan.brief else plan.reason
    return plan, Command(twist=plan.command, reason=reported, urgent=plan.urgent)


def _own_motion(
    step: StepInput, world: WorldModel, authority: Authority, intent: RiderIntent
) -> Command | None:
    """The rider's own motion, slower where people will be gone; None if something is in the way."""
    share = _clear_share(step, world, intent)
    if share is None and world.seen_walls is not world.walls:
        # A wall that only the map has turns no rider aside: the gate stops before it, and a
        # rider who pushes on opens it.
        share = _clear_share(step, replace(world, walls=world.seen_walls), intent)
    # Shares differ from tick to tick: where the chair has a path of its own, it plans instead.
    if share is None or (share < 1.0 and authority.yields):
        return None
    own = share * (authority.twist + np.array([0.0, 0.0, intent.return_rate]))
    return Command(twist=own, reason=_slowed(share))


def _planned_motion(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    intent: RiderIntent,
    previous: LocalPlan | None,
) -> LocalPlan:
    """Plan of the local planner, which tracks where the stick leads.

    Raises:
        ControlError: the planner has failed.
    """
    problem = local_problem(
        step,
        world,
        authority,
        intent.reference,
        Allowance(
            speed_limit=max(intent.speed, _SLOWEST),
            stalled=intent.squeezes,
            max_deviation=step.setup.steering.max_deviation,
        ),
        profile=step.request.profile,
        walls=world.walls,
    )
    return step.setup.local_planner.plan(problem, previous)


def _creep(
    step: StepInput,
    world: WorldModel,
    twist: Floats,
    plan: LocalPlan,
    gate: Callable[[Floats], Decision],
) -> Command | None:
    """The rider's motion at creep speed, where the planner found none; None if it is not tried."""
    slow = slowly(twist, step.setup.robot.outline, step.setup.progress.creep_speed)
    if plan.reason is None or plan.urgent or _meets_people(step, world, slow):
        return None
    blocked = gate(slow).reason is Reason.BLOCKED
    if blocked and not is_standing_still(step.observation.twist):
        return None
    return Command(twist=slow, reason=None if blocked else Reason.TOO_CLOSE)


def _with_less_turn(
    step: StepInput, world: WorldModel, twist: Floats, plan: LocalPlan, intent: RiderIntent
) -> Command | None:
    """The planned motion with less of its turn, for a stick that is not to be turned early."""
    if plan.reason is not None or intent.late_time <= 0.0:
        return None
    least = _least_change(step, world, plan.command, float(twist[2]) + intent.return_rate, intent)
    return None if least is None else Command(twist=least)


def _waiting_or_without_push(
    step: StepInput, world: WorldModel, intent: RiderIntent, twist: Floats
) -> Command:
    """Motion of a chair that waits before a passage, turns on the spot, backs up or stands."""
    if intent.waits:
        return Command(twist=np.zeros(3), reason=Reason.WAITING)
    turn = _turn_share(step, world, intent, twist)
    return Command(twist=twist * np.array([1.0, 1.0, turn]))


def slowly(twist: Floats, outline: Floats, speed: float) -> Floats:
    """Share of a twist (3,) at which no corner of an outline (k, 2) is faster than ``speed``."""
    x, y = outline.T
    corners = np.hypot(twist[0] - twist[2] * y, twist[1] + twist[2] * x)
    slower: Floats = twist * min(1.0, speed / max(float(corners.max()), 1e-6))
    return slower


def _meets_people(step: StepInput, world: WorldModel, twist: Floats) -> bool:
    """Check for people whom a twist (3,) would soon meet; the gate sees only the next stop."""
    steps = max(round(_SOON / step.setup.local_planner.step), 1)
    inputs = np.tile(step.setup.robot.motion_model.input(twist), (steps, 1))
    margins = ContactMargins(wall=0.0, people=_PEOPLE_GAP)
    return bool((_contacts(step, world, inputs, margins)[1:] < np.inf).any())


def _least_change(
    step: StepInput, world: WorldModel, planned: Floats, own: float, intent: RiderIntent
) -> Floats | None:
    """Planned twist (3,) with the turn rate that differs least from the rider's own, rad/s.

    None if each of them soon meets something: then only the plan itself leads out.
    """
    robot = step.setup.robot
    steps = max(round(intent.late_time / step.setup.local_planner.step), 1)
    margins = _clear_of(step, intent)
    for share in _CHANGES:
        tried = np.array([planned[0], planned[1], own + share * (planned[2] - own)])
        inputs = np.tile(robot.motion_model.input(tried), (steps, 1))
        if (_contacts(step, world, inputs, margins) == np.inf).all():
            return tried
    return None


def _turn_share(step: StepInput, world: WorldModel, intent: RiderIntent, twist: Floats) -> float:
    """Share of a turn on the spot; less beside a wall, which a corner may sweep."""
    if twist[0] != 0.0 or twist[2] == 0.0:
        return 1.0
    steps = max(round(_SWEPT_TIME / step.setup.local_planner.step), 1)
    inputs = np.tile(step.setup.robot.motion_model.input(twist), (steps, 1))
    near = bool(_contacts(step, world, inputs, _clear_of(step, intent))[0] < np.inf)
    return min(intent.turn_share, _BESIDE_WALL) if near else intent.turn_share


def _slowed(share: float) -> Reason | None:
    if share == 1.0:
        return None
    return Reason.TOO_CLOSE if share > 0.0 else Reason.BLOCKED


def _clear_share(step: StepInput, world: WorldModel, intent: RiderIntent) -> float | None:
    """Share of the rider's speed at which the way is clear; None: something is in the way.

    Only people who walk, and will be gone, are waited for.
    """
    walks = np.hypot(*world.people.mean[:, 2:].T) >= step.setup.recovery.walking_speed
    near = np.append(intent.clear_time, np.where(walks, np.inf, intent.clear_time))
    margins = _clear_of(step, intent)
    met = _contacts(step, world, intent.inputs, margins) < near
    if not met.any():
        return 1.0
    if met[0] or (met[1:] & ~walks).any():
        return None
    for share in _SHARES:
        slower = share * intent.inputs
        if share == 0.0 or not (_contacts(step, world, slower, margins) < near).any():
            return share
    return 0.0


def _clear_of(step: StepInput, intent: RiderIntent) -> ContactMargins:
    """Margins of a clear way."""
    return ContactMargins(
        wall=intent.wall_gap,
        people=step.setup.steering.people_gap,
        extra=max(step.request.extra_clearance, 0.0),
        standing_share=step.setup.clearance.standing,
    )


def _contacts(
    step: StepInput, world: WorldModel, inputs: Floats, margins: ContactMargins
) -> Floats:
    """Times (1 + n,) at which the motion meets walls and each person, s; else +inf.

    The inputs (k, m) count up to ``clear_time``.
    """
    setup, p = step.setup, step.setup.steering
    dt = setup.local_planner.step
    count = max(round(p.clear_time / dt), 1)
    poses = setup.robot.motion_model.rollout(step.observation.pose, inputs[:count], dt)
    return contact_times(
        setup.robot,
        poses,
        dt,
        people=world.people,
        predictions=world.predictions,
        walls=world.walls,
        margins=margins,
    )
