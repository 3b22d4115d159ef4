"""Final decision of a step: the command of rider or planner behind the safety gate."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.maps import DistanceField
from cohelm.messages import Decision, Mode, Reason
from cohelm.navigation.command import Command
from cohelm.navigation.floor import within_known_floor
from cohelm.navigation.local_walls import local_walls
from cohelm.navigation.tick import StepInput
from cohelm.navigation.world_model import WorldModel
from cohelm.perception.ground.ground_map import without_edges
from cohelm.safety import gate, stop


def decide(
    step: StepInput,
    world: WorldModel,
    command: Command,
    *,
    by_rider: bool,
    barriers: DistanceField,
    map_walls: DistanceField,
) -> Decision:
    """Pass the command through the gate; keep its own reason where the gate gives none.

    A plan keeps clear of walls by itself, the motion of a rider who is helped does not.

    Args:
        step: input of the step.
        world: people and obstacles.
        command: of rider or planner.
        by_rider: it is the motion of a rider who is helped, and no plan.
        barriers: distance to the walls of the map and to keepout zones.
        map_walls: distance to the walls of the map alone; the same object without such zones.
    """
    if step.request.mode in {Mode.ASSISTED, Mode.SHARED}:
        mode = Mode.ASSISTED if by_rider else Mode.SHARED
        step = replace(step, request=replace(step.request, mode=mode))
    if command.twist is None:
        return stop(command.reason or Reason.PLANNING)
    decision = within_known_floor(gated(command.twist, step, world, world.walls), step, world.floor)
    if command.urgent:
        decision = replace(decision, twist=np.zeros(3), emergency=True)
    if decision.reason is Reason.BLOCKED:
        decision = _with_cause(decision, command.twist, step, world, barriers, map_walls)
    if decision.reason is None and command.reason is not None:
        return replace(decision, reason=command.reason)
    return decision


def _with_cause(
    decision: Decision,
    twist: Floats,
    step: StepInput,
    world: WorldModel,
    barriers: DistanceField,
    map_walls: DistanceField,
) -> Decision:
    """The decision with a keepout zone or an edge of the floor as its reason, if it is one."""
    setup, position = step.setup, step.observation.pose[:2]
    without = {}
    if barriers is not map_walls:
        without[Reason.KEEPOUT] = map_walls, world.live
    if world.floor is not None and len(world.floor.edges.cells):
        without[Reason.EDGE_AHEAD] = (
            barriers,
            without_edges(world.layer.obstacles, world.floor.edges),
        )
    for reason, (static, live) in without.items():
        walls = local_walls(setup.grid, static, live, world.openings.opened, position, setup.window)
        if gated(twist, step, world, walls).reason is not Reason.BLOCKED:
            return replace(decision, reason=reason)
    return decision


def gated(twist: Floats, step: StepInput, world: WorldModel, walls: DistanceField) -> Decision:
    """Decision of the safety gate on a twist (3,)."""
    return gate(
        twist,
        step.observation,
        step.request,
        step.setup.robot,
        walls=walls,
        people=world.people,
        predictions=world.predictions,
        clearance=step.setup.clearance,
        parameters=step.setup.gate,
    )
