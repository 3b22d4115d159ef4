"""scans → people → predictions → spaces, and everything else as walls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cohelm.maps import DistanceField
from cohelm.messages import (
    Groups,
    LiveObstacles,
    Observation,
    People,
    Predictions,
    Request,
    Sensing,
    SocialSpaces,
)
from cohelm.navigation.beyond import NOTHING, Beyond, remember
from cohelm.navigation.crowding import CrowdingState, crowding
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.stopwatch import Stopwatch
from cohelm.navigation.tick import Memory
from cohelm.navigation.walls import walls_about
from cohelm.perception import (
    Detections,
    ObstacleLayerState,
    PerceptionMemory,
    perceive,
    update_obstacle_layer,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """What perception and the social model make of an observation."""

    people: People
    groups: Groups
    predictions: Predictions
    spaces: SocialSpaces
    walls: DistanceField
    """About the robot."""
    live: LiveObstacles
    sensing: Sensing
    detections: tuple[Detections, ...]
    """Of each scan that came."""
    perception: PerceptionMemory
    predictor: Any
    """The predictor's memory."""
    layer: ObstacleLayerState
    beyond: Beyond
    """What stands outside the layer's window."""
    crowding: CrowdingState


def see(
    setup: NavigatorSetup,
    map_walls: DistanceField,
    barriers: DistanceField,
    observation: Observation,
    request: Request,
    *,
    memory: Memory | None,
    watch: Stopwatch,
) -> Sight:
    """Who is there, where they will be, what space is theirs, and what else stands about.

    Args:
        setup: the parts.
        map_walls: distance field of the static map.
        barriers: the same with keepout zones as walls, for whoever steers.
        observation: usable, see ``safety.check_input``.
        request: for the rider's social distance.
        memory: of the last tick, None at first.
        watch: books the time.
    """
    planner = setup.local_planner
    perceived, perception = perceive(
        setup.perception, observation, map_walls, memory.perception if memory else None
    )
    people, groups, detections = perceived.people, perceived.groups, perceived.detections
    layer = update_obstacle_layer(
        memory.obstacles if memory else None,
        detections,
        people,
        setup.grid,
        observation.pose,
        setup.obstacle_layer,
    )
    beyond, layer = remember(
        (memory.beyond if memory else None) or NOTHING,
        memory.obstacles if memory else None,
        layer,
        setup.obstacle_layer,
    )
    watch.lap("perception")
    crowded = crowding(
        memory.crowding if memory else None, people, setup.grid, setup.heat, setup.crowding
    )
    predictions, predictor = setup.predictor.predict(
        people, planner.steps, planner.step, memory.predictor if memory else None
    )
    spaces = setup.social_model.spaces(
        people, groups, predictions, observation.twist, request.profile
    )
    watch.lap("social")
    live = layer.obstacles
    walls = walls_about(setup.grid, barriers, live, observation.pose[:2], setup.window)
    watch.lap("walls")
    return Sight(
        people=people,
        groups=groups,
        predictions=predictions,
        spaces=spaces,
        walls=walls,
        live=live,
        sensing=perceived.sensing,
        detections=detections,
        perception=perception,
        predictor=predictor,
        layer=layer,
        beyond=beyond,
        crowding=crowded,
    )
