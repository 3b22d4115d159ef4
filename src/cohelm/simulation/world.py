"""Simulated world: a chair, its rider, people and sensors.

``observe`` returns the navigator's input, ``advance`` takes its decision, and ``truth`` is for
evaluation only. Every source of randomness has its own generator, named by its purpose, so that an
additional sensor does not change the pedestrians. The same setup and seed give the same ride bit
for bit.

The rider sits and sees people and free distances. Walls and objects hide the people behind them,
even if they are low; people hide no one. The limits are assumed: eyes and neck together cover more
than the front of the chair.

A floor may have a relief: ramps, bars, kerbs, pits and stairs, on which 3-D sensors have
returns. The planar chair rides on it without slipping or tipping; a wheel that drops farther than
the chair may step down has fallen, and one that meets a step that it may not climb hits a wall.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, replace, value
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision, Observation
from cohelm.robots import Robot
from cohelm.simulation.api import Crowd, CrowdScene, PedestrianModel, Rider, RiderAct, RiderView
from cohelm.simulation.contact import gap_to_people, gap_to_walls
from cohelm.simulation.crowds.motion import displacement, interpolated
from cohelm.simulation.drivetrain import drive_command
from cohelm.simulation.dynamic_objects import (
    ManualDoor,
    MapChange,
    braking_outlines,
    current_grid,
    is_clear,
    with_shut_doors,
)
from cohelm.simulation.faults import Fault, FaultInjector
from cohelm.simulation.ground_truth import GroundTruth
from cohelm.simulation.random_streams import generator
from cohelm.simulation.sensing import SensorReadings, SensorSuite
from cohelm.simulation.sensors.floor_relief import FLAT, FloorRelief, floor_cells
from cohelm.simulation.sensors.grid_raycast import cast, in_sight
from cohelm.simulation.sensors.human_bodies import STEP_LENGTH, HumanBodies
from cohelm.simulation.sensors.localisation import Localisation, Odometry, with_error
from cohelm.simulation.sensors.planar_bodies import BodyKind
from cohelm.simulation.sensors.static_scene import StaticScene
from cohelm.simulation.simulated_chair import Contacts, CrowdStep, PlanarChair, SimulatedChair
from cohelm.simulation.split_knowledge import GoalChange, SplitCells, grid_views
from cohelm.simulation.wall_geometry import walls_of


@value
class WorldSetup:
    """Everything that defines a world, except for the seed."""

    grid: OccupancyGrid
    """True obstacles at time 0."""
    changes: tuple[MapChange, ...] = ()
    """Later obstacles, in the order of their times."""
    heights: Annotated[Floats32, Shape("rows cols")] | None = None
    """Heights of all obstacles of the ride, m, for 3-D sensors; see ``StaticScene``."""
    wall_height: float = 2.5
    """m."""
    ceiling: float = math.inf
    """Height of the ceiling, m; +inf: none."""
    relief: FloorRelief = FLAT
    """Heights of the floor."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    """X_MR at time 0."""
    crowd: Crowd
    """People at time 0."""
    statures: Annotated[Floats, Shape("n")] | None = None
    """Their heights, m, for 3-D sensors; None: 1.7 m each."""
    kinds: Annotated[Integers, Shape("n")] | None = None
    """Their outlines in planar scans, a ``BodyKind`` each; None: discs."""
    pedestrian_model: PedestrianModel
    rider: Rider
    rider_goal: Annotated[Floats, Shape("2")]
    """Destination of the rider, m."""
    rider_route: Annotated[Floats, Shape("k 2")]
    """Desired route of the rider, m; empty: straight to the destination."""
    goal_change: GoalChange | None = None
    """Destination that the rider decides for on the way."""
    split: SplitCells | None = None
    """Cells that rider and chair see differently; None: none."""
    localisation: Localisation = Localisation()
    odometry: Odometry = Odometry()
    control_step: float = 0.05
    """Time between decisions, s."""
    physics_step: float = 0.01
    """Upper bound, s; a control step is a whole number of them."""
    give_people: bool = False
    """Put the true people into the observation."""
    faults: tuple[Fault, ...] = ()
    doors: tuple[ManualDoor, ...] = ()
    """Doors for :meth:`.world.World.set_door`; open at first."""

    @property
    def last_goal(self) -> Floats:
        """Destination (2,) of the rider in the end, m."""
        return self.rider_goal if self.goal_change is None else self.goal_change.goal


@value
class NewPedestrian:
    """A pedestrian without a group, with w way-points."""

    position: Annotated[Floats, Shape("2")]
    """m."""
    waypoints: Annotated[Floats, Shape("w 2")]
    """In order, m; w = 0: standing."""
    heading: float = 0.0
    """Direction faced, rad."""
    speed: float = 1.2
    """Preferred speed, m/s."""
    radius: float = 0.25
    """Radius of the body, m."""
    stature: float = 1.7
    """Height, m."""
    loop: bool = False
    """Start again at the first way-point after the last."""
    sees_robot: bool = True
    """Avoid the robot."""


def with_pedestrian(crowd: Crowd, new: NewPedestrian) -> Crowd:
    """Append a pedestrian to the crowd; indices of the others stay.

    The model's private state of the new one is NaN: an inattentive person has not noticed the
    chair, a distracted one has not turned, and in a replayed film the new one follows the model of
    the scenario's other people.
    """
    n = len(crowd.radius)
    width = max(crowd.waypoints.shape[1], len(new.waypoints), 1)
    waypoints = np.full((n + 1, width, 2), np.nan)
    waypoints[:n, : crowd.waypoints.shape[1]] = crowd.waypoints
    waypoints[n, : len(new.waypoints)] = new.waypoints
    group, present, memory = crowd.group, crowd.present, crowd.memory
    return replace(
        crowd,
        position=np.vstack([crowd.position, new.position]),
        velocity=np.vstack([crowd.velocity, np.zeros(2)]),
        heading=np.append(crowd.heading, new.heading),
        radius=np.append(crowd.radius, new.radius),
        preferred_speed=np.append(crowd.preferred_speed, new.speed),
        waypoints=waypoints,
        target=np.append(crowd.target, np.int64(0)),
        loop=np.append(crowd.loop, np.bool_(new.loop)),
        sees_robot=np.append(crowd.sees_robot, np.bool_(new.sees_robot)),
        group=None if group is None else np.append(group, np.int64(-1)),
        present=None if present is None else np.append(present, np.True_),
        memory=None if memory is None else np.vstack([memory, np.full(memory.shape[1], np.nan)]),
    )


FIELD = math.radians(110.0)
"""Half the field of view, rad: of the eyes, and a turn of the head."""
PEOPLE_RANGE = 10.0
"""Distance up to which a rider sees people, m."""
OBSTACLE_RANGE = 5.0
"""Distance up to which a rider sees walls and objects, m."""
DIRECTIONS = np.linspace(-FIELD, FIELD, 45)
"""Viewing directions, 5° apart, rad."""
_NO_DISCS = np.empty((0, 3))


def view_from(
    grid: OccupancyGrid, pose: Floats, crowd: Crowd, kept_clear: OccupancyGrid | None = None
) -> tuple[Floats, Floats]:
    """Compute the view from the origin of a chair at ``pose`` (3,), X_MR.

    Args:
        grid: true obstacles.
        pose: of the chair.
        crowd: true people.
        kept_clear: obstacles and floor that the rider avoids, which end a free distance but hide
            nobody; None: the true obstacles alone.

    Returns:
        People in sight, (n, 5) as (x, y, v_x, v_y, radius) in the chair's frame; and the free
        distance along ``DIRECTIONS``, (b,), m, +inf beyond ``OBSTACLE_RANGE``.
    """
    blocked = walls_of(grid, unknown=False).solid
    ends = walls_of(kept_clear or grid, unknown=False).solid
    free = cast(ends, grid.resolution, grid.X_MG, _NO_DISCS, pose, DIRECTIONS, OBSTACLE_RANGE)
    position = transform(inverse(pose), crowd.position)
    visible = np.hypot(*position.T) <= PEOPLE_RANGE
    visible &= np.abs(np.arctan2(position[:, 1], position[:, 0])) <= FIELD
    if visible.any():
        to = crowd.position[visible]
        eyes = np.broadcast_to(pose[:2], to.shape)
        visible[visible] = in_sight(blocked, grid.resolution, grid.X_MG, eyes.copy(), to)
    velocity = transform([0.0, 0.0, -pose[2]], crowd.velocity)
    return np.column_stack([position, velocity, crowd.radius])[visible], free


_ROUNDING = 1e-4
"""Bound on the rounding error of a step, m."""
STATURE = 1.7
"""Default height of people, m."""
ChairMaker = Callable[[WorldSetup], SimulatedChair]
"""Makes the chair of a world, at its start."""
_STREAMS = ("people", "localisation", "odometry", "rider", "strides", "newcomers")


class World:
    """World of one ride; the only object of the simulator that changes.

    Args:
        setup: definition of the world.
        seed: of all randomness, ≥ 0.
        make_chair: makes the chair; None: a planar one.
    """

    def __init__(self, setup: WorldSetup, seed: int, make_chair: ChairMaker | None = None) -> None:
        self.setup = setup
        self._random = {purpose: generator(seed, purpose) for purpose in _STREAMS}
        self._ticks = 0
        self._shut: frozenset[int] = frozenset()
        self._open = setup.grid
        self._views = grid_views(setup.grid, setup.split)
        self._goal_changed = False
        self._scene = StaticScene(
            grid=self._views.sensed,
            heights=setup.heights,
            wall_height=setup.wall_height,
            ceiling=setup.ceiling,
            cells=floor_cells(setup.relief, setup.grid),
        )
        self._sensors = SensorSuite(setup.robot, seed)
        self._faults = FaultInjector(setup.faults, seed)
        self._command: Floats | None = None
        self._walked = self._random["strides"].uniform(
            0.0, 2.0 * STEP_LENGTH * STATURE, len(setup.crowd.radius)
        )
        statures = setup.statures
        self._statures = np.full_like(self._walked, STATURE) if statures is None else statures
        self._kinds = setup.kinds
        planar = PlanarChair(setup.robot, setup.start)
        self._chair: SimulatedChair = planar if make_chair is None else make_chair(setup)
        self._act: RiderAct | None = None
        self._error = setup.localisation.first(self._random["localisation"])
        self._wheels = self._wheel_heights()
        self._truth = self._ground_truth(_no_contact(setup.crowd))
        readings = self._sense(0.0, setup.crowd, setup.crowd, 1.0)
        self._observation = self._observe(readings)

    def branch(self, faults: tuple[Fault, ...]) -> World:
        """Copy that goes on with other faults, as if it had had them from the start.

        Neither changes the other. No fault of either may have begun yet.
        """
        out = copy.copy(self)
        out.setup = replace(self.setup, faults=faults)
        for name in ("_random", "_sensors"):
            setattr(out, name, copy.deepcopy(getattr(self, name)))
        for name in ("_walked", "_statures"):
            setattr(out, name, getattr(self, name).copy())
        out._chair = self._chair.branch()
        out._faults = self._faults.branch(faults)
        return out

    @property
    def truth(self) -> GroundTruth:
        """True state; not for the navigator."""
        return self._truth

    @property
    def grid(self) -> OccupancyGrid:
        """True obstacles now; not for the navigator."""
        return self._views.truth

    @property
    def shut(self) -> frozenset[int]:
        """Indices of the doors that are shut."""
        return self._shut

    def observe(self) -> Observation:
        """Return the current observation, which changes only with ``advance``."""
        return self._observation

    def advance(self, decision: Decision) -> None:
        """Simulate one control step under ``decision``.

        Contact does not stop the world; the caller decides whether the ride ends.
        """
        setup = self.setup
        before, old_grid = self._truth.crowd, self.grid
        grid = self._update_grid()
        if grid is not old_grid:
            self._views = grid_views(grid, setup.split)
            self._scene = replace(self._scene, grid=self._views.sensed)
        steps = max(round(setup.control_step / setup.physics_step), 1)
        dt = setup.control_step / steps
        start = self._ticks * setup.control_step
        after = setup.pedestrian_model.step(
            before, self._crowd_scene(), setup.control_step, self._random["people"]
        )
        readings, sent = SensorReadings(), decision.twist
        decision = self._faults.received(decision, start)
        command = self._faults.command(drive_command(setup.robot, decision), start)
        self._carry(start)
        walked = np.hypot(*displacement(before, after).T)
        same = self.grid is old_grid
        self._chair.begin(
            CrowdStep(
                before=before,
                after=after,
                people=lambda share: self._people(before, after, share, walked),
                grid=self.grid,
                gap_people=self._truth.gap_people,
                gap_wall=self._truth.gap_wall if same else 0.0,
            )
        )
        for k in range(1, steps + 1):
            self._chair.move(command, dt, k / steps, lambda twist: self._faults.twist(twist, start))
            time = start + k * dt
            if self._sensors.are_due(time):
                readings += self._sense(time, before, after, k / steps)
        contacts = self._with_steps(self._chair.end())
        self._walked += walked
        self._ticks += 1
        self._command = sent
        self._truth = self._ground_truth(contacts)
        self._error = setup.localisation.after(
            self._error, setup.control_step, self._random["localisation"]
        )
        self._observation = self._observe(readings)

    def spawn(self, new: NewPedestrian) -> int:
        """Add a pedestrian between two steps, and return their index.

        The ride before it is unchanged; the same pedestrians at the same times give the same ride.
        """
        truth, crowd = self._truth, with_pedestrian(self._truth.crowd, new)
        phase = self._random["newcomers"].uniform(0.0, 2.0 * STEP_LENGTH * new.stature)
        self._walked = np.append(self._walked, phase)
        self._statures = np.append(self._statures, new.stature)
        if self._kinds is not None:
            self._kinds = np.append(self._kinds, np.int64(BodyKind.DISC))
        self._truth = replace(
            truth,
            crowd=crowd,
            gap_people=self._gaps(crowd.position, crowd.radius, crowd.there),
            hit_moving=np.append(truth.hit_moving, np.False_),
            hit_standing=np.append(truth.hit_standing, np.False_),
        )
        return len(crowd.radius) - 1

    def set_door(self, door: int, *, shut: bool) -> bool:
        """Shut or open a door, from the next step on.

        Returns:
            True if the door moved; it stays open if the leaf would come within 0.1 m of a person,
            of the chair, or of the chair's stopping distance.

        Raises:
            IndexError: if there is no such door.
        """
        if not 0 <= door < len(self.setup.doors):
            raise IndexError(f"no door {door}: there are {len(self.setup.doors)} doors")
        shut_doors = self._shut | {door} if shut else self._shut - {door}
        if shut_doors != self._shut and shut:
            robot, drive, bodies = self.setup.robot, self._chair, self._bodies()
            outlines = braking_outlines(
                robot.outline, drive.pose, drive.twist, robot.max_deceleration
            )
            then, now = self._with_doors(shut_doors), self._with_doors(self._shut)
            if not all(is_clear(then, now, outline, bodies) for outline in outlines):
                return False
        self._shut = shut_doors
        return True

    def _with_doors(self, shut: frozenset[int]) -> OccupancyGrid:
        return with_shut_doors(self._open, tuple(self.setup.doors[door] for door in sorted(shut)))

    def _update_grid(self) -> OccupancyGrid:
        """Apply due changes; a timed door waits for people and chair in its way."""
        if self.setup.changes:
            outline = transform(self._chair.pose, self.setup.robot.outline)
            self._open = current_grid(
                self.setup.changes, self._open, self._now, outline, self._bodies()
            )
        return self._with_doors(self._shut)

    def _bodies(self) -> Floats:
        """Present people, (n, 3) as (x, y, radius), m."""
        crowd = self._truth.crowd
        return np.column_stack([crowd.position, crowd.radius])[crowd.there]

    @property
    def _now(self) -> float:
        return self._ticks * self.setup.control_step

    def _carry(self, time: float) -> None:
        pose = self._chair.pose
        there = self._faults.carried(pose, self.grid, self._bodies(), time)
        if there is not pose:
            self._chair.carry(there)
            self._wheels = self._wheel_heights()

    def _wheel_heights(self) -> Floats:
        """Height (k,) of the floor under each wheel, m."""
        return self._scene.floor_height(transform(self._chair.pose, self.setup.robot.wheels))

    def _with_steps(self, contacts: Contacts) -> Contacts:
        """Add the steps that wheels met and could not take."""
        if self._scene.cells is None:
            return contacts
        robot, before = self.setup.robot, self._wheels
        self._wheels = self._wheel_heights()
        rise = self._wheels - before
        return replace(
            contacts,
            hit_wall=contacts.hit_wall or bool((rise > robot.max_step_up + _ROUNDING).any()),
            fell=bool((-rise > robot.max_step_down + _ROUNDING).any()),
        )

    def _ground_truth(self, contacts: Contacts) -> GroundTruth:
        pose, outline, crowd = self._chair.pose, self.setup.robot.outline, contacts.after
        return GroundTruth(
            time=self._now,
            pose=pose,
            twist=self._chair.twist,
            crowd=crowd,
            gap_people=self._gaps(crowd.position, crowd.radius, crowd.there),
            gap_wall=gap_to_walls(outline, pose, self.grid),
            hit_moving=contacts.hit_moving,
            hit_standing=contacts.hit_standing,
            hit_wall=contacts.hit_wall,
            fell=contacts.fell,
            touches=contacts.touches,
        )

    def _gaps(self, position: Floats, radius: Floats, there: Booleans) -> Floats:
        """Gap (n,) between footprint and each body, m; +inf for absent people."""
        gaps = gap_to_people(self.setup.robot.outline, self._chair.pose, position, radius)
        return np.where(there, gaps, np.inf)

    @cached_property
    def _disc(self) -> tuple[Floats, float]:
        """Disc about the footprint: (centre (2,) in the robot frame, radius), m."""
        outline = self.setup.robot.outline
        centre = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
        return centre, float(np.hypot(*(outline - centre).T).max())

    def _crowd_scene(self) -> CrowdScene:
        """Surroundings of the pedestrians; the chair is the disc about its footprint."""
        drive = self._chair
        centre, radius = self._disc
        vx, vy, turn_rate = drive.twist
        velocity = np.array([vx - turn_rate * centre[1], vy + turn_rate * centre[0]])
        return CrowdScene(
            grid=self.grid,
            robot_position=transform(drive.pose, centre),
            robot_velocity=transform([0.0, 0.0, drive.pose[2]], velocity),
            robot_radius=radius,
            time=self._now,
            robot_heading=drive.pose[2],
            robot_outline=transform(drive.pose, self.setup.robot.outline),
        )

    def _sense(self, time: float, before: Crowd, after: Crowd, share: float) -> SensorReadings:
        """Return the sweeps due at ``time``, a share of a control step after ``before``."""
        unseen = self._faults.unseen(len(before.there), time)
        there = before.there & after.there & ~unseen
        walked = np.hypot(*displacement(before, after).T)
        bodies = self._people(before, after, share, walked, there)
        return self._sensors.sense(time, self._chair.casting(self._scene, bodies, there))

    def _people(
        self,
        before: Crowd,
        after: Crowd,
        share: float,
        walked: Floats,
        which: Booleans | slice = slice(None),
    ) -> HumanBodies:
        """Some people, a share of a control step after ``before``; walked: (n,) in it, m."""
        return HumanBodies(
            position=interpolated(before, after, share)[which],
            heading=after.heading[which],
            walked=(self._walked + share * walked)[which],
            speed=walked[which] / self.setup.control_step,
            height=self._statures[which],
            radius=before.radius[which],
            kind=None if self._kinds is None else self._kinds[which],
        )

    def _observe(self, readings: SensorReadings) -> Observation:
        setup, truth = self.setup, self._truth
        memory: Any | None = self._act.memory if self._act is not None else None
        self._act = setup.rider.act(self._rider_view(), memory, self._random["rider"])
        observation = Observation(
            time=truth.time,
            # Along the heading at the start, so that a rotated world has the same ride rotated.
            pose=with_error(truth.pose, self._error, axis=setup.start[2]),
            pose_time=truth.time,
            twist=setup.odometry.measure(self._chair.wheel_twist, self._random["odometry"]),
            twist_time=truth.time,
            command=self._command,
            scans=readings.scans,
            clouds=readings.clouds,
            rider=self._act.command,
            people=truth.as_people() if setup.give_people else None,
            inertial=self._chair.inertial,
        )
        return self._faults.observed(observation)

    def _rider_view(self) -> RiderView:
        setup, truth, change = self.setup, self._truth, self.setup.goal_change
        if change is not None and not self._goal_changed:
            self._goal_changed = change.is_due(truth.pose[:2])
        changed = change if self._goal_changed else None
        view = RiderView(
            time=truth.time,
            pose=truth.pose,
            twist=truth.twist,
            goal=changed.goal if changed else setup.rider_goal,
            route=changed.route if changed else setup.rider_route,
            outline=setup.robot.outline,
        )
        if not getattr(setup.rider, "needs_view", True):
            return view
        people, free = view_from(self.grid, truth.pose, truth.crowd, self._views.rider)
        return replace(view, people=people, bearings=DIRECTIONS, free=free)


def _no_contact(crowd: Crowd) -> Contacts:
    none = np.zeros(len(crowd.radius), dtype=bool)
    return Contacts(hit_moving=none, hit_standing=none, hit_wall=False, after=crowd)
