"""The pipeline: one observation in, one tick out; the only place where the stages meet."""

from __future__ import annotations

import dataclasses
import time as clock
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.control import LocalPlanner, LocalProblem
from cohelm.errors import ControlError, PlanningError
from cohelm.maps import DistanceField, OccupancyGrid, distance_field
from cohelm.messages import (
    Authority,
    Decision,
    Groups,
    LiveObstacles,
    LocalPlan,
    Mode,
    Observation,
    People,
    Predictions,
    Reason,
    Reference,
    Request,
    SocialSpaces,
)
from cohelm.navigation.progress import ProgressParameters, ProgressState, progress
from cohelm.navigation.replanning import (
    ReplanningParameters,
    RouteQuestion,
    RouteState,
    route,
)
from cohelm.navigation.tick import Memory, Tick
from cohelm.navigation.walls import walls_about
from cohelm.perception import (
    Detector,
    ObstacleLayerParameters,
    ObstacleLayerState,
    Predictor,
    Tracker,
    update_obstacle_layer,
)
from cohelm.planning import GlobalPlanner, reference
from cohelm.robots import Robot
from cohelm.safety import GateParameters, GateState, check_input, gate, stop
from cohelm.sharing import AuthorityParameters, authority, blended
from cohelm.social import SocialModel


@value
class NavigatorSetup:
    """A map, a robot and the parts."""

    grid: OccupancyGrid
    robot: Robot
    global_planner: GlobalPlanner
    local_planner: LocalPlanner
    detector: Detector
    tracker: Tracker
    predictor: Predictor
    social_model: SocialModel
    obstacle_layer: ObstacleLayerParameters = ObstacleLayerParameters()
    authority: AuthorityParameters = AuthorityParameters()
    replanning: ReplanningParameters = ReplanningParameters()
    progress: ProgressParameters = ProgressParameters()
    gate: GateParameters = GateParameters()
    goal_tolerance: float = 0.12
    """Distance at which the goal is reached and the chair stays, m."""
    window: float = 8.0
    """Half the side of the window in which walls matter to the local planner, m."""


class Navigator:
    """From what is known to what the wheels do.

    It holds nothing that changes: what a stage needs of the past comes back in the last tick.

    Args:
        setup: a map, a robot and the parts.
    """

    def __init__(self, setup: NavigatorSetup) -> None:
        self.setup = setup
        self.walls = distance_field(setup.grid)

    def step(self, observation: Observation, request: Request, last: Tick | None) -> Tick:
        """One tick.

        Planning and control errors become a stop whose reason a rider can read; any other error is
        a fault of the program and passes through, so that ticks cease and the watchdog acts.
        """
        setup, watch = self.setup, Stopwatch()
        memory = last.memory if last else None
        fault, gate_state = check_input(
            observation, request, setup.robot, memory.gate if memory else None, setup.gate
        )
        if fault is not None:
            return _blind(observation, request, fault, gate_state, last)
        seen = self._see(observation, request, memory, watch)
        hand, hand_state = authority(
            observation,
            request.profile,
            setup.robot,
            steps=setup.local_planner.steps,
            step=setup.local_planner.step,
            speed_limit=_speed_limit(setup.robot, request),
            memory=memory.authority if memory else None,
            parameters=setup.authority,
        )
        watch.lap("sharing")
        course = self._course(observation, request, seen, hand, memory, watch)
        arrived = self._arrived(observation, request, last)
        plan, wanted = self._want(observation, request, seen, hand, course, last, arrived=arrived)
        watch.lap("control")
        decision = self._decide(observation, request, seen, wanted)
        watch.lap("safety")
        return Tick(
            observation=observation,
            request=request,
            decision=decision,
            memory=Memory(
                gate=gate_state,
                tracker=seen.tracker,
                obstacles=seen.layer,
                route=course.route,
                progress=course.progress,
                authority=hand_state,
            ),
            people=seen.people,
            groups=seen.groups,
            predictions=seen.predictions,
            spaces=seen.spaces,
            path=course.route.path if course.route else None,
            reference=course.reference,
            authority=hand,
            shared=course.shared,
            plan=plan,
            arrived=arrived,
            durations=MappingProxyType(watch.laps),
        )

    def _see(
        self, observation: Observation, request: Request, memory: Memory | None, watch: Stopwatch
    ) -> _Seen:
        """Scans → people → predictions → spaces, and everything else as walls."""
        setup, planner = self.setup, self.setup.local_planner
        detections = tuple(
            setup.detector.detect(scan, observation.pose, self.walls) for scan in observation.scans
        )
        people, tracker = setup.tracker.track(
            observation, detections, memory.tracker if memory else None
        )
        layer = update_obstacle_layer(
            memory.obstacles if memory else None,
            detections,
            people,
            setup.grid,
            observation.pose,
            setup.obstacle_layer,
        )
        watch.lap("perception")
        groups = Groups.alone(len(people))
        predictions = setup.predictor.predict(people, planner.steps, planner.step)
        spaces = setup.social_model.spaces(
            people, groups, predictions, observation.twist, request.profile
        )
        watch.lap("social")
        live = layer.obstacles
        walls = walls_about(setup.grid, self.walls, live, observation.pose[:2], setup.window)
        watch.lap("walls")
        return _Seen(
            people=people,
            groups=groups,
            predictions=predictions,
            spaces=spaces,
            walls=walls,
            live=live,
            tracker=tracker,
            layer=layer,
        )

    def _course(
        self,
        observation: Observation,
        request: Request,
        seen: _Seen,
        hand: Authority,
        memory: Memory | None,
        watch: Stopwatch,
    ) -> _Course:
        """Goal → path → reference, blended with the rider's states; or why there is none."""
        setup, planner = self.setup, self.setup.local_planner
        before, pace = (memory.route, memory.progress) if memory else (None, None)
        stalled = observation.time - pace.since if pace else 0.0
        question = RouteQuestion(
            time=observation.time,
            request=request,
            pose=observation.pose,
            robot=setup.robot,
            grid=setup.grid,
            live=seen.live,
            walls=seen.walls,
            authority=hand if request.mode is Mode.SHARED else None,
            stalled_for=stalled,
        )
        try:
            state = route(question, setup.global_planner, before, setup.replanning)
        except PlanningError as error:
            watch.lap("planning")
            return _Course(reason=_reason(error))
        path = state.path
        along, at = reference(
            path,
            observation.pose,
            observation.twist,
            steps=planner.steps,
            step=planner.step,
            speed=_speed_limit(setup.robot, request),
            robot=setup.robot,
            progress=state.progress,
        )
        state = dataclasses.replace(state, progress=at)
        pace = progress(path.length - at, observation.time, state.planned_at, pace, setup.progress)
        shared = blended(along, hand) if request.mode is Mode.SHARED else along
        watch.lap("planning")
        return _Course(route=state, reference=along, shared=shared, progress=pace)

    def _arrived(self, observation: Observation, request: Request, last: Tick | None) -> bool:
        """Within the tolerance; once there, still there a little beyond it."""
        setup = self.setup
        away = float(np.hypot(*(request.goal - observation.pose[:2])))
        stays = (
            last is not None and last.arrived and np.array_equal(last.request.goal, request.goal)
        )
        return bool(away <= setup.goal_tolerance * (2.0 if stays else 1.0))

    def _want(
        self,
        observation: Observation,
        request: Request,
        seen: _Seen,
        hand: Authority,
        course: _Course,
        last: Tick | None,
        *,
        arrived: bool,
    ) -> tuple[LocalPlan | None, _Wanted]:
        """The twist that planner or rider want, or why to stand."""
        if request.mode in {Mode.MANUAL, Mode.ASSISTED}:
            return None, _Wanted(twist=hand.twist)
        if hand.wants_stop:
            return None, _Wanted(reason=Reason.RIDER_STOP)
        if arrived:
            return None, _Wanted(reason=Reason.ARRIVED)
        if course.shared is None:
            return None, _Wanted(reason=course.reason)
        problem = LocalProblem(
            time=observation.time,
            robot=self.setup.robot,
            pose=observation.pose,
            twist=observation.twist,
            reference=course.shared,
            people=seen.people,
            predictions=seen.predictions,
            spaces=seen.spaces,
            walls=seen.walls,
            authority=hand,
            profile=request.profile,
            speed_limit=_speed_limit(self.setup.robot, request),
        )
        try:
            plan = self.setup.local_planner.plan(problem, last.plan if last else None)
        except ControlError:
            return None, _Wanted(reason=Reason.SOLVER_FAILED)
        return plan, _Wanted(twist=plan.command, reason=plan.reason)

    def _decide(
        self, observation: Observation, request: Request, seen: _Seen, wanted: _Wanted
    ) -> Decision:
        """The gate's word; the planner's own reason where the gate has none."""
        if wanted.twist is None:
            return stop(wanted.reason or Reason.PLANNING)
        decision = gate(
            wanted.twist,
            observation,
            request,
            self.setup.robot,
            walls=seen.walls,
            people=seen.people,
            predictions=seen.predictions,
            parameters=self.setup.gate,
        )
        if decision.reason is None and wanted.reason is not None:
            return dataclasses.replace(decision, reason=wanted.reason)
        return decision


class Stopwatch:
    """Thread CPU time from lap to lap, s."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = clock.thread_time()

    def lap(self, name: str) -> None:
        """Book the time since the last lap under ``name``."""
        now = clock.thread_time()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last
        self._last = now


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seen:
    """What perception and the social model make of an observation."""

    people: People
    groups: Groups
    predictions: Predictions
    spaces: SocialSpaces
    walls: DistanceField
    live: LiveObstacles
    tracker: Any
    layer: ObstacleLayerState


@dataclass(frozen=True, slots=True, kw_only=True)
class _Course:
    """Where to go, or why nowhere."""

    route: RouteState | None = None
    reference: Reference | None = None
    shared: Reference | None = None
    progress: ProgressState | None = None
    reason: Reason = Reason.PLANNING


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wanted:
    """A twist, or None and why."""

    twist: Floats | None = None
    reason: Reason | None = None


def _blind(
    observation: Observation,
    request: Request,
    reason: Reason,
    gate_state: GateState,
    last: Tick | None,
) -> Tick:
    """A stop without a look at anything; what the stages remember is kept."""
    memory = last.memory if last else Memory(gate=gate_state)
    return Tick(
        observation=observation,
        request=request,
        decision=stop(reason),
        memory=dataclasses.replace(memory, gate=gate_state),
        people=last.people if last else People.nobody(observation.time),
        path=last.path if last else None,
        arrived=last.arrived if last else False,
    )


def _speed_limit(robot: Robot, request: Request) -> float:
    return min(robot.max_speed, request.speed_limit, request.profile.preferred_speed)


def _reason(error: PlanningError) -> Reason:
    known = {reason.value: reason for reason in Reason}
    return known.get(error.code, Reason.PLANNING)
