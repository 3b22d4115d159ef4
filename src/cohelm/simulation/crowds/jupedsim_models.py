"""Pedestrians of JuPedSim: collision-free speed, anticipation velocity and social force.

JuPedSim keeps its state in a running simulation. Here one is built from the crowd in every step, so
that the crowd is the whole state: agents start one iteration back as points, walk to their places
at their velocities, and get their bodies there. The step then goes on as one running simulation
would. People who do not see the chair walk in a second simulation without it; in each simulation
the others go straight on.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation.api import Crowd, CrowdScene
from cohelm.simulation.crowds.motion import advance_targets, current_targets, turned_towards

try:
    import jupedsim as jps
    import shapely
    from jupedsim import native
    from jupedsim.geometry_utils import build_geometry
except ImportError as cause:
    raise ImportError(f"{cause}: pip install 'cohelm[crowds]'") from cause

_ITERATION = 0.01
"""Recommended time step of JuPedSim, s."""
_SLIT, _TOLERANCE = 0.06, 0.04
"""Half the width of slits that are closed, and tolerance of simplified walls, m."""
_INSIDE, _CLEAR = 0.02, 0.3
"""Distance from walls to which people in them and way-points in them are moved, m."""
_AHEAD = 0.2
"""Time for which those go straight on whom a simulation does not move, s: longer than a step."""
_MIN_AREA = 1.0
"""Smaller free areas are left out, m²."""
_RADIUS = 1e-5
"""Radius of an agent when it is added, m: JuPedSim refuses bodies that touch."""
_AGENTS: dict[str, tuple[Any, dict[str, float]]] = {
    "collision_free_speed": (
        jps.CollisionFreeSpeedModelV2AgentParameters,
        {"strength_neighbor_repulsion": 0.0, "strength_geometry_repulsion": 0.0, "time_gap": 0.1},
    ),
    "anticipation_velocity": (
        jps.AnticipationVelocityModelAgentParameters,
        {"strength_neighbor_repulsion": 0.0, "wall_buffer_distance": 0.0, "time_gap": 0.1},
    ),
    "social_force": (
        jps.SocialForceModelAgentParameters,
        {"mass": 1e6, "reaction_time": 1e3, "agent_scale": 0.0, "obstacle_scale": 0.0},
    ),
}
"""Parameters of an agent, and values with which nothing slows or pushes it."""


class JuPedSim:
    """People of a model of JuPedSim; the disc around the chair is an agent among them."""

    class Parameters(Model):
        """Model; agents have JuPedSim's default parameters, except for radius and speed."""

        model: Literal["collision_free_speed", "anticipation_velocity", "social_force"] = (
            "collision_free_speed"
        )
        """Collision-free speed V2 (Tordeux et al. 2016), anticipation velocity (Xu et al. 2021), or
        social force (Helbing et al. 2000)."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to the direction of motion, s (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        target = advance_targets(crowd.position, crowd.waypoints, crowd.target, crowd.loop)
        goals, seed = current_targets(crowd.waypoints, target), int(rng.integers(2**63))
        position, velocity = crowd.position.copy(), np.zeros_like(crowd.velocity)
        areas = walkable_areas(scene.grid)
        place = _nearest(areas, crowd.position)
        for k, area in enumerate(areas):
            here = crowd.there & (place == k)
            chair = bool(shapely.contains_xy(area.inside, *scene.robot_position))
            for sees in (False, True):
                walks = here & (crowd.sees_robot == sees)
                if walks.any():
                    bodies = _bodies(crowd, goals, walks, here, scene if sees and chair else None)
                    states = self._simulate(bodies, area, dt, seed)
                    position[walks], velocity[walks] = np.hsplit(states, 2)
        return replace(
            crowd,
            position=position,
            velocity=velocity,
            heading=turned_towards(crowd.heading, velocity, dt, self.parameters.turn_time),
            target=target,
        )

    def _simulate(self, bodies: _Bodies, area: WalkableArea, dt: float, seed: int) -> Floats:
        """States (k, 4) of those who walk, (x, y, v_x, v_y), ``dt`` later."""
        iterations = max(round(dt / _ITERATION), 1)
        h = dt / iterations
        sim = native.Simulation(model=self._model(seed), geometry=area.native, dt=h)
        agents = self._placed(sim, bodies, area, h)
        # Forces of contact would burst.
        shares = _shares(bodies) if self.parameters.model == "social_force" else 1.0
        radius = shares * bodies.radius
        parameters, unmoved = _AGENTS[self.parameters.model]
        normal, goals = parameters(), _moved(bodies.goal, area.inside, area.clear)
        for i, agent in enumerate(agents):
            agent.target = tuple(goals[i])
            for name, number in unmoved.items():
                walks = i < bodies.walking
                setattr(agent.model, name, getattr(normal, name) if walks else number)
            agent.model.desired_speed, agent.model.radius = bodies.speed[i], radius[i]
        states = np.empty((iterations + 1, bodies.walking, 2))
        for k in range(iterations + 1):
            if k > 0:
                sim.iterate()
            states[k] = [agent.position for agent in agents[: bodies.walking]]
        return np.hstack([states[-1], (states[-1] - states[-2]) / h])

    def _placed(self, sim: Any, bodies: _Bodies, area: WalkableArea, h: float) -> list[Any]:
        """Add agents, as points at the bodies' places with their velocities."""
        forces = self.parameters.model == "social_force"
        start = bodies.position if forces else bodies.position - h * bodies.velocity
        parameters, unmoved = _AGENTS[self.parameters.model]
        stage, ids = sim.add_direct_steering_stage(), []
        journey = sim.add_journey(jps.JourneyDescription([stage])._obj)
        for at, velocity in zip(_moved(start, area.inside), bodies.velocity, strict=True):
            new = parameters(position=tuple(at), radius=_RADIUS, journey_id=journey, stage_id=stage)
            for name, number in ({"velocity": tuple(velocity)} if forces else unmoved).items():
                setattr(new, name, number)
            new.desired_speed = float(np.hypot(*velocity))
            ids.append(sim.add_agent(new.as_native()))
        agents = [sim.agent(agent) for agent in ids]
        if not forces:
            for agent, at in zip(agents, _moved(bodies.position, area.inside), strict=True):
                agent.target = tuple(at)
            sim.iterate()
        return agents

    def _model(self, seed: int) -> Any:
        if self.parameters.model == "collision_free_speed":
            return native.CollisionFreeSpeedModelV2Builder().build()
        if self.parameters.model == "social_force":
            usual = jps.SocialForceModel()
            return native.SocialForceModelBuilder(
                body_force=usual.body_force, friction=usual.friction
            ).build()
        usual = jps.AnticipationVelocityModel()
        return native.AnticipationVelocityModelBuilder(
            pushout_strength=usual.pushout_strength, rng_seed=seed
        ).build()


class WalkableArea(NamedTuple):
    """Connected free area of a grid."""

    native: Any
    """Geometry of JuPedSim."""
    inside: shapely.Geometry
    """Area for centres of people."""
    clear: shapely.Geometry
    """Area to which way-points in walls are moved."""


@lru_cache(maxsize=4)
def walkable_areas(grid: OccupancyGrid) -> tuple[WalkableArea, ...]:
    """Free areas of a grid without slits, with simplified walls, in the map frame.

    Args:
        grid: compared by identity, and it never changes; unknown cells are walls.
    """
    rows = np.pad(~grid.blocked(), ((0, 0), (1, 1))).astype(np.int8)
    row, column = np.nonzero(np.diff(rows, axis=1))
    # Rows of free cells begin and end in turn.
    runs = shapely.box(column[::2], row[::2], column[1::2], row[::2] + 1)
    area = shapely.transform(
        shapely.union_all(runs), lambda at: transform(grid.X_MG, at * grid.resolution)
    )
    area = area.buffer(-_SLIT, join_style="mitre").buffer(_SLIT, join_style="mitre")
    parts = shapely.get_parts(area.simplify(_TOLERANCE).buffer(0.0))
    out = []
    for part in parts[shapely.area(parts) > _MIN_AREA]:
        inside, clear = part.buffer(-_INSIDE), part.buffer(-_CLEAR)
        shapely.prepare(inside)
        out.append(
            WalkableArea(build_geometry(part)._obj, inside, inside if clear.is_empty else clear)
        )
    return tuple(out)


def _nearest(areas: tuple[WalkableArea, ...], position: Floats) -> Integers:
    """Index (n,) of the area nearest to each person."""
    points = shapely.points(position)
    return np.asarray(np.argmin([shapely.distance(a.inside, points) for a in areas], axis=0))


class _Bodies(NamedTuple):
    """Agents of a simulation: first those who walk, then the others, who go straight on."""

    walking: int
    """Number of those who walk."""
    position: Floats
    velocity: Floats
    radius: Floats
    goal: Floats
    speed: Floats


def _bodies(
    crowd: Crowd, goals: Floats, walks: Booleans, here: Booleans, scene: CrowdScene | None
) -> _Bodies:
    """People ``walks`` of all ``here``, masks (n,), and the robot of the scene, if one is given.

    ``goals`` (n, 2) are current way-points; NaN: stand.
    """
    people = np.concatenate([np.flatnonzero(walks), np.flatnonzero(here & ~walks)])
    position, velocity = crowd.position[people], crowd.velocity[people]
    radius, count = crowd.radius[people], int(walks.sum())
    if scene is not None:
        position = np.vstack([position, scene.robot_position])
        velocity = np.vstack([velocity, scene.robot_velocity])
        radius = np.append(radius, scene.robot_radius)
    goal, speed = position + _AHEAD * velocity, np.hypot(*velocity.T)
    stands = np.isnan(goals[walks, 0])
    goal[:count] = np.where(stands[:, None], position[:count], goals[walks])
    speed[:count] = np.where(stands, 0.0, crowd.preferred_speed[walks])
    return _Bodies(count, position, velocity, radius, goal, speed)


def _shares(bodies: _Bodies) -> Floats:
    """Shares (n,) of the radii with which nobody who walks overlaps another."""
    apart = np.hypot(*(bodies.position[:, None] - bodies.position).transpose(2, 0, 1))
    shares = apart / (bodies.radius[:, None] + bodies.radius)
    np.fill_diagonal(shares, 1.0)
    shares[bodies.walking :, bodies.walking :] = 1.0
    return np.asarray(shares.min(axis=1).clip(max=1.0))


def _moved(points: Floats, inside: shapely.Geometry, to: shapely.Geometry | None = None) -> Floats:
    """Points (n, 2), those that are not inside moved to the nearest place of ``to``."""
    out = points.copy()
    for i in np.flatnonzero(~shapely.contains_xy(inside, points)):
        line = shapely.shortest_line(inside if to is None else to, shapely.Point(points[i]))
        out[i] = shapely.get_coordinates(line)[0]
    return out
