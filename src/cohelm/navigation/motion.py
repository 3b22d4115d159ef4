"""Motion of one step: the command of a planner, or of a rider who is helped with steering."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.messages import Authority, LocalPlan, Mode
from cohelm.navigation.command import Command
from cohelm.navigation.final_decision import gated
from cohelm.navigation.path_and_reference import PathAndReference
from cohelm.navigation.steering_help import steer
from cohelm.navigation.tick import StepInput, Tick
from cohelm.navigation.world_model import WorldModel
from cohelm.sharing import RiderIntent, SteeringState


class Motion(NamedTuple):
    """Command of rider or planner."""

    plan: LocalPlan | None
    """Plan that the command comes from; None: it does not come from a plan."""
    command: Command
    course: PathAndReference
    steering: SteeringState | None = None
    own: LocalPlan | None = None
    """The chair's own plan, also while it yields."""
    by_rider: bool = False
    """The command is the motion of a rider who is helped, and no plan."""


def helped_motion(
    step: StepInput,
    world: WorldModel,
    authority: Authority,
    course: PathAndReference,
    intent: RiderIntent,
    last: Tick | None,
) -> Motion:
    """Motion of a rider who is helped with steering, also one to whom the chair yields."""
    request = replace(step.request, mode=Mode.ASSISTED)
    step = replace(step, request=request)
    plan, command = steer(
        step,
        world,
        authority,
        intent,
        last.plan if last else None,
        lambda twist: gated(twist, step, world, world.walls),
    )
    if authority.yields and plan is None and command.twist is not None:
        command = replace(command, twist=_reachable(step, command.twist))
    course = replace(course, shared=intent.reference)
    return Motion(plan, command, course, by_rider=plan is None)


def _reachable(step: StepInput, twist: Floats) -> Floats:
    """Twist (3,) with a speed that is reached within the accelerations, as that of a plan is.

    The stick of a rider who goes with the chair jumps more than one of a rider who drives alone.
    """
    robot, now = step.setup.robot, float(step.observation.twist[0])
    _, _, rise, fall = robot.input_bounds
    half = step.setup.local_planner.step / 2.0
    low, high = now - float(fall[0]) * half, now + float(rise[0]) * half
    return np.array([min(max(float(twist[0]), low), high), twist[1], twist[2]])
