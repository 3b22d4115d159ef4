"""World model update: scans → people → predictions → social spaces; everything else is walls.

It also keeps the time of the last contact: the chair stands for a moment after a person has walked
into it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, replace
from cohelm.health import Health
from cohelm.maps import DistanceField
from cohelm.messages import (
    Groups,
    LiveObstacles,
    Mode,
    Observation,
    People,
    Predictions,
    Reason,
    Sensing,
    SocialSpaces,
)
from cohelm.navigation.floor import update_floor
from cohelm.navigation.local_walls import local_walls
from cohelm.navigation.map_openings import (
    CLOSED,
    OPENING_SPEED,
    MapOpenings,
    update_openings,
)
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.standstill import is_standing_still
from cohelm.navigation.tick import Memory, StepInput
from cohelm.perception import (
    Detections,
    GroundMap,
    ObstacleLayerState,
    PerceptionMemory,
    perceive,
    update_obstacle_layer,
)
from cohelm.perception.ground.ground_map import open_edges, with_edges
from cohelm.robots import Robot
from cohelm.robots.contact import touching
from cohelm.robots.contact_kernel import WALKING
from cohelm.stopwatch import Stopwatch

_HIDDEN = -0.1
"""Gap of a person who is about to be hidden within the footprint, m."""
_PASSES = 2.0
"""Time in which such a person comes out again, s."""


def update_last_contact(
    before: float, robot: Robot, observation: Observation, people: People
) -> float:
    """Time when a walking person last touches the chair, s; ``before`` if nobody does now.

    A person behind a chair that drives on does not count. A person who overlaps the footprint is
    hidden from the sensors until they have passed, so their contact is expected to last.
    """
    pose, time = observation.pose, observation.time
    walks = np.hypot(people.mean[:, 2], people.mean[:, 3]) > WALKING
    ahead = np.array([np.cos(pose[2]), np.sin(pose[2])])
    behind = (people.mean[:, :2] - pose[:2]) @ ahead < robot.outline[:, 0].min()
    leaves = observation.twist[0] > WALKING
    counts = walks & ~(behind & leaves)
    if (touching(robot, pose, people, gap=_HIDDEN) & counts).any():
        return time + _PASSES
    if (touching(robot, pose, people) & counts).any():
        return max(time, before)
    return before


_PUSHED = 0.15
"""Deflection of a stick that would move a chair whose way is free, share of full."""
_OBSTRUCTED = frozenset({Reason.SCAN_IMPLAUSIBLE, Reason.SCAN_BLIND})
"""Reasons of health for which the rest of the view may still be believed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldModel:
    """Output of perception and the social model for one observation."""

    people: People
    groups: Groups
    predictions: Predictions
    spaces: SocialSpaces
    walls: DistanceField
    """Map, keepout zones and live obstacles, in a window about the robot."""
    seen_walls: DistanceField
    """The same without the walls of the map that the scan passes."""
    live: LiveObstacles
    """With the edges of the floor that the chair cannot take."""
    sensing: Sensing
    detections: tuple[Detections, ...]
    """One for each new scan."""
    perception: PerceptionMemory
    predictor: Any
    """Memory of the predictor."""
    layer: ObstacleLayerState
    floor: GroundMap | None
    """Map of the floor; None without clouds."""
    openings: MapOpenings
    """Walls of the map that the scan passes, and where the rider has pushed on."""
    last_contact: float
    """Time when a walking person last touched the chair, s."""


def update_world_model(
    step: StepInput,
    map_walls: DistanceField,
    barriers: DistanceField,
    openable: Booleans,
    stopwatch: Stopwatch,
) -> WorldModel:
    """Run perception, prediction and the social model.

    Args:
        step: input of the step.
        map_walls: distance field of the static map.
        barriers: the same with keepout zones as walls, which hold in every mode but manual.
        openable: (rows, cols) walls of the map that are no keepout zone.
        stopwatch: books the time by stage.
    """
    setup, observation, memory = step.setup, step.observation, step.memory
    perceived, perception = perceive(setup.perception, observation, map_walls, memory.perception)
    people, groups, detections = perceived.people, perceived.groups, perceived.detections
    layer = update_obstacle_layer(
        memory.obstacles,
        detections,
        people,
        setup.grid,
        observation.pose,
        setup.obstacle_layer,
    )
    stopwatch.lap("perception")
    predictions, predictor = setup.predictor.predict(
        people, setup.local_planner.steps, setup.local_planner.step, memory.predictor
    )
    spaces = setup.social_model.spaces(
        people, groups, predictions, observation.twist, step.request.profile
    )
    stopwatch.lap("social")
    floor = update_floor(step)
    stopwatch.lap("ground")
    live = layer.obstacles
    if floor is not None:
        over = step.request.over_edges
        live = open_edges(live, floor) if over else with_edges(live, floor.edges)
    openings = _openings(step, detections, openable)
    walls, seen_walls = _walls(step, barriers, live, openings)
    stopwatch.lap("walls")
    return WorldModel(
        people=people,
        groups=groups,
        predictions=predictions,
        spaces=spaces,
        walls=walls,
        seen_walls=seen_walls,
        live=live,
        sensing=perceived.sensing,
        detections=detections,
        perception=perception,
        predictor=predictor,
        layer=layer,
        floor=floor,
        openings=openings,
        last_contact=update_last_contact(memory.last_contact, setup.robot, observation, people),
    )


def _walls(
    step: StepInput, barriers: DistanceField, live: LiveObstacles, openings: MapOpenings
) -> tuple[DistanceField, DistanceField]:
    """Walls about the robot, and the same without those that the scan passes."""
    setup, position = step.setup, step.observation.pose[:2]
    walls = local_walls(setup.grid, barriers, live, openings.opened, position, setup.window)
    if len(openings.seen.codes) <= len(openings.opened.codes):
        return walls, walls
    return walls, local_walls(setup.grid, barriers, live, openings.seen, position, setup.window)


def _openings(
    step: StepInput, detections: tuple[Detections, ...], openable: Booleans
) -> MapOpenings:
    """Update the openings by new sweeps, and by a stick that moves nothing."""
    before, now = step.memory.openings or CLOSED, step.observation.time
    rider, mode = step.observation.rider, step.request.mode
    stick = np.zeros(2) if rider is None else np.abs(rider.deflection)
    pushes = mode in {Mode.ASSISTED, Mode.SHARED} and bool(stick.max() > _PUSHED)
    held = pushes and is_standing_still(step.observation.twist)
    return update_openings(
        before,
        detections,
        step.setup.grid,
        openable,
        pushes=pushes,
        held_since=min(before.held_since, now) if held else math.inf,
    )


def with_opening_speed(step: StepInput, world: WorldModel) -> StepInput:
    """Limit the speed of a chair that has just been led through a wall of the map."""
    if step.observation.time >= world.openings.slow_until:
        return step
    limit = min(step.request.speed_limit, OPENING_SPEED)
    return replace(step, request=replace(step.request, speed_limit=limit))


def keep_watching(
    setup: NavigatorSetup,
    map_walls: DistanceField,
    observation: Observation,
    health: Health,
    memory: Memory,
) -> tuple[Memory, People | None]:
    """Track people while the scanner's view is obstructed, so that they are known afterwards.

    People who press against the scanner hide others, but not all of them. A pose or odometry that
    contradicts other sensors would misplace people: then none is tracked, and None is returned.
    A person who walks into the standing chair is soon hidden, so the contact is remembered.
    """
    if health.stop not in _OBSTRUCTED:
        return memory, None
    seen, perception = perceive(setup.perception, observation, map_walls, memory.perception)
    touched = update_last_contact(memory.last_contact, setup.robot, observation, seen.people)
    return replace(memory, perception=perception, last_contact=touched), seen.people
