"""Run one ride: the only place where a world and a navigator meet."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.episode.ride import GOAL_RADIUS, Outcome, Replan, Ride
from cohelm.evaluation.episode.ride_log import StopLog, row_of, states_of
from cohelm.messages import Path
from cohelm.navigation import Navigator, Tick
from cohelm.platforms import Platform, SimulatedWorld, open_simulation
from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.scenario import Scenario
from cohelm.simulation import GroundTruth, is_standing

SETTLING = 2.0
"""Longest time from the arrival at the goal's radius to a standstill, s."""
PICTURE_STEP = 0.5
"""Time between the ticks that are recorded for pictures, s."""

Watcher = Callable[[Tick, GroundTruth], bool | None]
"""Called after every tick with the navigator's tick and the ground truth; True ends the ride."""


def run(scenario: Scenario, seed: int, on_tick: Watcher | None = None) -> Ride:
    """Run a ride of a scenario; equal scenarios and seeds give equal rides, except for durations.

    Raises:
        ConfigError, MapError, PluginError, PlanningError: see ``build_scenario``.
    """
    return Episode(build_scenario(scenario, seed)).run(on_tick)


class Episode:
    """Run of one ride.

    Args:
        setup: built scenario.
    """

    def __init__(self, setup: RideSetup) -> None:
        self.setup = setup

    def run(self, on_tick: Watcher | None = None) -> Ride:
        """Run the ride to its end: goal, collision, stop or time limit.

        Warns of faults that begin after the time limit.
        """
        limit = self.setup.scenario.time_limit
        for fault in self.setup.scenario.faults:
            if fault.at >= limit:
                warnings.warn(
                    f"the fault {fault.kind} begins at {fault.at:g} s and never acts: "
                    f"time_limit is {limit:g} s",
                    stacklevel=2,
                )
        platform, world = open_simulation(self.setup)
        navigator = Navigator(self.setup.navigator)
        return Course(self.setup, platform, world, navigator).run(on_tick)


class Course:
    """Ride under way.

    Args:
        setup: of the ride.
        platform: the chair.
        world: its ground truth.
        navigator: decides.
    """

    def __init__(
        self, setup: RideSetup, platform: Platform, world: SimulatedWorld, navigator: Navigator
    ) -> None:
        self.setup = setup
        self.world = world
        self._platform, self._navigator = platform, navigator
        self._record = _Record()
        self._tick: Tick | None = None

    def run(self, on_tick: Watcher | None = None) -> Ride:
        """Run the ride to its end: goal, collision, stop, time limit, or the watcher's word."""
        while True:
            ride = self.step(on_tick)
            if ride is not None:
                return ride

    def step(self, on_tick: Watcher | None = None) -> Ride | None:
        """Run one tick; the ride, if it has ended."""
        truth = self.world.truth
        tick = self._navigator.step(self._platform.observe(), self.setup.request, self._tick)
        self._tick = tick
        self._record.add(truth, tick)
        ended = on_tick is not None and on_tick(tick, truth)
        outcome = self._record.outcome(self.setup) or (Outcome.ENDED if ended else None)
        if outcome is not None:
            self._platform.close()
            return self._record.ride(self.setup, outcome)
        self._platform.apply(tick.decision)
        return None

    def branch(self, setup: RideSetup, platform: Platform, world: SimulatedWorld) -> Course:
        """Copy of the ride so far that goes on in a copy of its world; neither changes the other.

        Args:
            setup: of the copy; until now it must have been the same ride.
            platform: the chair in that world.
            world: its ground truth.
        """
        out = Course(setup, platform, world, self._navigator)
        out._record, out._tick = self._record.copy(), self._tick
        return out


class _Record:
    """Record of a ride so far."""

    def __init__(self) -> None:
        self.truths: list[GroundTruth] = []
        self.rows: list[Floats] = []
        self.durations: list[dict[str, float]] = []
        self.pictures: list[Tick] = []
        self.closest: tuple[float, Tick] | None = None
        self.stops = StopLog()
        self.replans: list[Replan] = []
        self._path: Path | None = None
        self.first: Tick | None = None
        self._entered: float | None = None

    def copy(self) -> _Record:
        """Copy that grows by itself; what is recorded is shared."""
        out = copy.copy(self)
        for name in ("truths", "rows", "durations", "pictures", "replans"):
            setattr(out, name, list(getattr(self, name)))
        out.stops = copy.deepcopy(self.stops)
        return out

    def add(self, truth: GroundTruth, tick: Tick) -> None:
        """Add one tick and its ground truth."""
        self.truths.append(truth)
        self.rows.append(row_of(tick))
        self.durations.append(dict(tick.durations))
        self.first = self.first or tick
        last = self.pictures[-1].observation.time if self.pictures else -np.inf
        if truth.time - last > PICTURE_STEP - 1e-9:
            self.pictures.append(tick)
        gap = float(truth.gap_people.min(initial=np.inf))
        if np.isfinite(gap) and (self.closest is None or gap < self.closest[0]):
            self.closest = gap, tick
        self.stops.add(truth, tick)
        self._add_path(truth, tick)

    def _add_path(self, truth: GroundTruth, tick: Tick) -> None:
        """Record a new path, except the first one."""
        route = tick.memory.route
        if route is None or route.path is self._path:
            return
        if self._path is not None:
            found = Replan(time=truth.time, why=route.reason, points=route.path.points)
            self.replans.append(found)
        self._path = route.path

    def outcome(self, setup: RideSetup) -> Outcome | None:
        """Outcome of the ride; None: it has not ended."""
        truth = self.truths[-1]
        if truth.fell:
            return Outcome.FELL
        if truth.hit_moving.any() or truth.hit_wall:
            return Outcome.COLLISION
        if np.hypot(*(truth.pose[:2] - setup.arrival)) > GOAL_RADIUS:
            self._entered = None
        else:
            self._entered = truth.time if self._entered is None else self._entered
            in_time = truth.time - self._entered <= SETTLING + 1e-9
            if in_time and bool(is_standing(truth.twist)):
                return Outcome.REACHED
        if self.stops.standing(truth.time) > setup.scenario.standing_limit:
            return Outcome.STOPPED
        if truth.time >= setup.scenario.time_limit - 1e-9:
            return Outcome.TIMEOUT
        return None

    def ride(self, setup: RideSetup, outcome: Outcome) -> Ride:
        """Ride as one value."""
        truths, rows = self.truths, np.array(self.rows)
        k, n = len(truths), len(truths[0].crowd.radius)
        people = [states_of(t.crowd) for t in truths]
        return Ride(
            scenario=setup.scenario,
            seed=setup.seed,
            outcome=outcome,
            robot=setup.robot,
            grid=setup.grid,
            world=setup.world.grid,
            places=setup.places,
            goal=setup.arrival,
            prefer=setup.prefer,
            step=setup.world.control_step,
            time=np.array([t.time for t in truths]),
            pose=np.array([t.pose for t in truths]),
            twist=np.array([t.twist for t in truths]),
            command=rows[:, :3],
            requested=rows[:, 3:6],
            stick=rows[:, 6:8],
            eta=rows[:, 8],
            gap_people=np.array([t.gap_people for t in truths]).reshape(k, n),
            gap_wall=np.array([t.gap_wall for t in truths]),
            hit_moving=np.array([t.hit_moving for t in truths]).reshape(k, n),
            hit_standing=np.array([t.hit_standing for t in truths]).reshape(k, n),
            hit_wall=np.array([t.hit_wall for t in truths]),
            people=np.array(people).reshape(k, n, 4),
            people_heading=np.array([t.crowd.heading for t in truths]).reshape(k, n),
            people_target=np.array([t.crowd.target for t in truths]).reshape(k, n),
            people_radius=truths[0].crowd.radius,
            people_see=truths[0].crowd.sees_robot,
            setup=setup.world,
            stops=tuple(self.stops.all),
            path=self.first.path if self.first is not None else None,
            replans=tuple(self.replans),
            ticks=tuple(self.pictures),
            closest=self.closest[1] if self.closest is not None else None,
            durations=_by_stage(self.durations),
        )


def _by_stage(durations: list[dict[str, float]]) -> MappingProxyType[str, Floats]:
    """Durations (k,) of each stage, 0 where it did not run, and of the whole tick."""
    stages = sorted({stage for each in durations for stage in each} - {"tick"})
    by_stage = {s: np.array([each.get(s, 0.0) for each in durations]) for s in stages}
    whole = np.sum(list(by_stage.values()), axis=0) if by_stage else np.zeros(len(durations))
    return MappingProxyType({**by_stage, "tick": whole})
