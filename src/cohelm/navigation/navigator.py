"""The navigator: one observation in, one tick out; the only place where all stages meet."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm import sharing
from cohelm.arrays import Floats
from cohelm.control import LocalProblem
from cohelm.control.trajectories import gentle_stop
from cohelm.errors import ControlError
from cohelm.health import beam_map, monitor
from cohelm.maps import DistanceField, distance_field
from cohelm.messages import (
    Authority,
    ChairConfidence,
    Decision,
    DestinationBelief,
    LocalPlan,
    Mode,
    Observation,
    Reason,
    Reference,
    Request,
)
from cohelm.navigation.belief_help import with_belief_help
from cohelm.navigation.chair_confidence import update_confidence
from cohelm.navigation.command import Allowance, Command, local_problem, tight_limit
from cohelm.navigation.destination_inference import DestinationState, destination_inference
from cohelm.navigation.local_walls import local_walls
from cohelm.navigation.path_and_reference import PathAndReference, plan_path_and_reference
from cohelm.navigation.recovery.context import update_recovery, with_recovery_reason
from cohelm.navigation.recovery.stages import RecoveryAction
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.stage_results import (
    StageResults,
    stopped_by_health,
    stopped_by_input,
    tick_of,
    with_health_reason,
)
from cohelm.navigation.static_people import with_closed_side
from cohelm.navigation.steering_help import intent_of, steer
from cohelm.navigation.tick import Memory, StepInput, Tick
from cohelm.navigation.world_model import WorldModel, update_world_model
from cohelm.navigation.yielding import rider_inputs, with_yielding
from cohelm.navigation.zones import with_keepout_walls, with_zone_limits
from cohelm.safety import check_input, gate, stop
from cohelm.sharing import AuthorityState
from cohelm.stopwatch import Stopwatch


class Navigator:
    """The pipeline from an observation to the command for the wheels.

    It holds nothing that changes: state that a stage needs again comes back in the last tick.

    Args:
        setup: map, robot and parts.
    """

    def __init__(self, setup: NavigatorSetup) -> None:
        self.setup = setup
        self.walls = distance_field(setup.grid)
        closed = with_keepout_walls(setup.grid, setup.filters)
        self.beams = beam_map(setup.grid, self.walls)
        self.barriers = self.walls if closed is setup.grid else distance_field(closed)
        self.destinations = destination_inference(
            setup.grid,
            setup.filters,
            setup.places,
            setup.robot.inscribed_radius,
            setup.destinations,
        )

    def step(self, observation: Observation, request: Request, last: Tick | None) -> Tick:
        """Compute one tick.

        Planning and control errors become a stop with a reason that the rider can read. Any other
        exception is a program error and propagates, so that ticks cease and the watchdog acts.

        Args:
            observation: everything known of the world now.
            request: goal, mode and limits.
            last: the previous tick, None at first.
        """
        stopwatch = Stopwatch()
        memory = last.memory if last else Memory()

        # Input that is invalid or too old stops the chair before any stage uses it.
        fault, gate_state = check_input(
            observation, request, self.setup.robot, memory.gate, self.setup.gate
        )
        if fault is not None:
            return stopped_by_input(observation, request, fault, gate_state, last)

        # Redundant input that does not agree slows the chair, or stops it.
        health, health_state = monitor(
            observation, request, self.setup.robot, self.beams, memory.health, self.setup.health
        )
        memory = dataclasses.replace(memory, health=health_state)
        if health.stop is not None:
            return stopped_by_health(observation, request, health, gate_state, memory, last)
        limited = dataclasses.replace(
            request, speed_limit=min(request.speed_limit, health.speed_limit)
        )
        stopwatch.lap("health")

        step = self._step_input(observation, _with_mode(limited), memory, last)
        world = update_world_model(step, self.walls, self.barriers, stopwatch)
        confidence = update_confidence(observation, self.walls, memory.confidence)
        authority, authority_state = self._rider_authority(step, confidence)
        authority, yielding = with_yielding(step, authority, last)
        destinations, destination_state = self._destinations(step, authority)
        stopwatch.lap("sharing")

        # Recovery, if the ride makes no progress although it should.
        arrived = self._has_arrived(step, last)
        hold = arrived or self._holds(step.request, authority)
        update = update_recovery(step, world, authority, hold=hold)
        recovery = update.action
        authority = self._limit_authority(step, authority, recovery)

        course = plan_path_and_reference(step, world, authority, recovery, hold=hold)
        stopwatch.lap("planning")
        steering = None
        if step.request.mode is Mode.SHARED:
            intent, steering = intent_of(step, world, authority)
            course = dataclasses.replace(course, rider_inputs=rider_inputs(authority, intent))
        if step.request.mode is Mode.ASSISTED:
            helped = with_belief_help(step, self.destinations, destinations, authority)
            intent, steering = intent_of(step, world, helped)
            course = dataclasses.replace(course, shared=intent.reference)
            plan, command = steer(
                step,
                world,
                helped,
                intent,
                last.plan if last else None,
                lambda twist: self._gate(twist, step, world, world.walls),
            )
        else:
            plan, command = self._plan(
                step, world, authority, course, recovery=recovery, last=last, arrived=arrived
            )
        stopwatch.lap("control")

        # The gate has the last word.
        decision = self._decide(step, world, command, planned=plan is not None)
        decision = with_recovery_reason(decision, plan, observation.twist, recovery)
        decision = with_health_reason(decision, health)
        stopwatch.lap("safety")
        results = StageResults(
            gate=gate_state,
            health=health,
            health_state=health_state,
            world=world,
            authority_state=authority_state,
            authority=authority,
            arrived=arrived,
            recovery=update,
            course=course,
            plan=plan,
            decision=decision,
            steering=steering,
            yielding=yielding,
            confidence=confidence,
            destinations=destinations,
            destination_state=destination_state,
        )
        return tick_of(observation, request, results, stopwatch.laps)

    def _step_input(
        self, observation: Observation, request: Request, memory: Memory, last: Tick | None
    ) -> StepInput:
        """Apply the speed limits of the map, which hold for all stages."""
        setup = self.setup
        limited = with_zone_limits(
            request, setup.filters, setup.robot, observation, memory.route, setup.zones
        )
        return StepInput(
            setup=setup,
            observation=observation,
            request=limited,
            memory=memory,
            commanded=last.decision.twist if last else None,
        )

    def _rider_authority(
        self, step: StepInput, confidence: ChairConfidence
    ) -> tuple[Authority, AuthorityState]:
        """Compute the rider's input and its weight η."""
        setup = self.setup
        return sharing.authority(
            step.observation,
            step.request.profile,
            setup.robot,
            horizon=sharing.InputHorizon(
                steps=setup.local_planner.steps, step=setup.local_planner.step
            ),
            speed_limit=setup.speed_limit(step.request),
            memory=step.memory.authority,
            parameters=setup.authority,
            chair=confidence.total,
        )

    def _destinations(
        self, step: StepInput, authority: Authority
    ) -> tuple[DestinationBelief | None, DestinationState | None]:
        """Infer destinations while the rider has chosen none."""
        if self.destinations is None or not np.isnan(step.request.goal).any():
            return None, None
        return self.destinations.update(
            step.observation.time,
            step.observation.pose,
            authority.deflection,
            self.setup.robot.max_turn_rate,
            step.memory.destinations,
        )

    def _has_arrived(self, step: StepInput, last: Tick | None) -> bool:
        """Check the distance to the goal, with hysteresis.

        The tolerance of a slow chair is larger, so that it does not turn for the last centimetres.
        """
        setup, observation, request = self.setup, step.observation, step.request
        distance = float(np.hypot(*(request.goal - observation.pose[:2])))
        stays = (
            last is not None and last.arrived and np.array_equal(last.request.goal, request.goal)
        )
        slow = float(np.hypot(*observation.twist[:2])) < setup.goal_slow_speed
        if not stays and slow and last is not None:
            return bool(distance <= max(setup.goal_slow_tolerance, setup.goal_tolerance))
        return bool(distance <= setup.goal_tolerance * (2.0 if stays else 1.0))

    def _holds(self, request: Request, authority: Authority) -> bool:
        """Check that the chair need not make progress: the rider drives or requests a stop."""
        return (
            request.mode.rider_drives
            or authority.wants_stop
            or authority.yields
            or self.setup.speed_limit(request) <= 0.0
        )

    def _limit_authority(
        self, step: StepInput, authority: Authority, recovery: RecoveryAction
    ) -> Authority:
        """Reduce η where the chair takes over: during recovery and at the end of the path."""
        route = step.memory.route
        if step.request.mode is not Mode.SHARED or route is None:
            return authority
        if recovery.takes_over:
            # A chair at rest must not set off against a stick that is pulled back.
            if authority.deflection[0] <= -self.setup.authority.stop_deflection:
                return authority
            return dataclasses.replace(authority, eta=0.0)
        if authority.yields:
            return authority
        remaining = route.path.length - route.progress
        return sharing.limit_authority(authority, remaining, self.setup.authority)

    def _plan(
        self,
        step: StepInput,
        world: WorldModel,
        authority: Authority,
        course: PathAndReference,
        *,
        recovery: RecoveryAction,
        last: Tick | None,
        arrived: bool,
    ) -> tuple[LocalPlan | None, Command]:
        """Compute the command of rider or local planner, or the reason to stop."""
        setup, request = step.setup, step.request
        if request.mode.rider_drives:
            return None, Command(twist=authority.twist)
        if authority.wants_stop:
            return None, Command(reason=Reason.RIDER_STOP)
        if arrived:
            begin = step.observation.twist if last is None else last.decision.twist
            twist = gentle_stop(setup.robot, begin)
            return None, Command(twist=twist, reason=Reason.ARRIVED)
        if course.shared is None:
            reason = course.failure.reason if course.failure else Reason.PLANNING
            return None, Command(reason=reason)
        problem = self._local_problem(step, world, authority, course, course.shared, recovery)
        try:
            plan = setup.local_planner.plan(problem, last.plan if last else None)
        except ControlError:
            return None, Command(reason=Reason.SOLVER_FAILED)
        told = None if plan.brief else plan.reason
        return plan, Command(twist=plan.command, reason=told, urgent=plan.urgent)

    def _local_problem(
        self,
        step: StepInput,
        world: WorldModel,
        authority: Authority,
        course: PathAndReference,
        reference: Reference,
        recovery: RecoveryAction,
    ) -> LocalProblem:
        """Problem of the local planner, with the limits and the passing side of a recovery."""
        profile, walls = step.request.profile, world.walls
        if recovery.side != "none":
            profile = profile.model_copy(update={"passing_side": recovery.side})
            walls = self._walls_with_closed_side(step.observation.pose, world, recovery)
        allowance = Allowance(
            speed_limit=min(course.speed_limit, tight_limit(step, world)),
            stalled=recovery.creeps,
            reverses=recovery.reverses,
            rider_inputs=course.rider_inputs,
        )
        return local_problem(
            step, world, authority, reference, allowance, profile=profile, walls=walls
        )

    def _walls_with_closed_side(
        self, pose: Floats, world: WorldModel, recovery: RecoveryAction
    ) -> DistanceField:
        """Close the side that the rider did not select for passing."""
        setup, speed = self.setup, self.setup.replanning.standing_speed
        live = with_closed_side(recovery.side, world.live, setup.grid, world.people, pose, speed)
        return local_walls(setup.grid, self.barriers, live, pose[:2], setup.window)

    def _decide(
        self, step: StepInput, world: WorldModel, command: Command, *, planned: bool
    ) -> Decision:
        """Pass the command through the gate; keep its own reason where the gate gives none.

        A plan keeps clear of walls by itself, also if the rider drives.
        """
        if planned and step.request.mode is Mode.ASSISTED:
            shared = dataclasses.replace(step.request, mode=Mode.SHARED)
            step = dataclasses.replace(step, request=shared)
        if command.twist is None:
            return stop(command.reason or Reason.PLANNING)
        decision = self._gate(command.twist, step, world, world.walls)
        if command.urgent:
            decision = dataclasses.replace(decision, twist=np.zeros(3), emergency=True)
        if decision.reason is Reason.BLOCKED and self._only_keepout(command.twist, step, world):
            return dataclasses.replace(decision, reason=Reason.KEEPOUT)
        if decision.reason is None and command.reason is not None:
            return dataclasses.replace(decision, reason=command.reason)
        return decision

    def _only_keepout(self, twist: Floats, step: StepInput, world: WorldModel) -> bool:
        """Check that without keepout zones the gate would let the twist pass."""
        if self.barriers is self.walls:
            return False
        setup, position = self.setup, step.observation.pose[:2]
        physical = local_walls(setup.grid, self.walls, world.live, position, setup.window)
        return self._gate(twist, step, world, physical).reason is not Reason.BLOCKED

    def _gate(
        self, twist: Floats, step: StepInput, world: WorldModel, walls: DistanceField
    ) -> Decision:
        return gate(
            twist,
            step.observation,
            step.request,
            self.setup.robot,
            walls=walls,
            people=world.people,
            predictions=world.predictions,
            clearance=self.setup.clearance,
            parameters=self.setup.gate,
        )


def _with_mode(request: Request) -> Request:
    """Shared control without a destination is help with steering."""
    if request.mode is Mode.SHARED and np.isnan(request.goal).any():
        return dataclasses.replace(request, mode=Mode.ASSISTED)
    return request
