"""The navigator: one observation in, one tick out; the only place where all stages meet.

``Navigator.step`` is the pipeline; the functions before it are its two small stages without a
module of their own: the rider's destinations, and the rider's authority in one step.
"""

from __future__ import annotations

import copy

import numpy as np

from cohelm import sharing
from cohelm.arrays import Floats, replace
from cohelm.control import LocalProblem
from cohelm.control.trajectories import gentle_stop
from cohelm.errors import ControlError
from cohelm.health import NO_CHANGES, Health, HealthState, MapChanges, beam_map, monitor, registered
from cohelm.maps import DistanceField, distance_field
from cohelm.maps.masks import closed_cells
from cohelm.messages import (
    Authority,
    Decision,
    DestinationBelief,
    LocalPlan,
    Mode,
    Observation,
    Reason,
    Reference,
    Request,
)
from cohelm.navigation.command import Allowance, Command, local_problem, tight_limit
from cohelm.navigation.destination_inference import (
    DestinationInference,
    DestinationState,
    destination_inference,
)
from cohelm.navigation.final_approach import has_arrived
from cohelm.navigation.final_decision import decide
from cohelm.navigation.floor import with_floor_limit
from cohelm.navigation.local_walls import local_walls
from cohelm.navigation.motion import Motion, helped_motion
from cohelm.navigation.path_and_reference import PathAndReference, plan_path_and_reference
from cohelm.navigation.recovery.context import update_recovery, with_recovery_reason
from cohelm.navigation.recovery.stages import RecoveryAction
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.stage_results import (
    CheckedInput,
    Sharing,
    StageResults,
    stopped_by_health,
    stopped_by_input,
    tick_of,
    with_health_reason,
)
from cohelm.navigation.static_people import with_closed_side
from cohelm.navigation.steering_help import intent_of
from cohelm.navigation.tick import Memory, StepInput, Tick
from cohelm.navigation.world_model import (
    WorldModel,
    keep_watching,
    update_world_model,
    with_opening_speed,
)
from cohelm.navigation.yielding import rider_inputs, with_yielding
from cohelm.navigation.zones import with_keepout_walls, with_zone_limits
from cohelm.safety import check_input
from cohelm.sharing import AuthorityState
from cohelm.stopwatch import Stopwatch


def inferred_destinations(
    inference: DestinationInference | None, step: StepInput, authority: Authority
) -> tuple[DestinationBelief | None, DestinationState | None]:
    """Infer destinations while the rider has chosen none; also return the memory.

    Args:
        inference: of the map; None: it has no named places.
        step: input of the step.
        authority: of the rider.
    """
    if inference is None or not np.isnan(step.request.goal).any():
        return None, None
    return inference.update(
        step.observation.time,
        step.observation.pose,
        authority.deflection,
        step.setup.robot.max_turn_rate,
        step.memory.destinations,
    )


def rider_authority(step: StepInput) -> tuple[Authority, AuthorityState]:
    """Compute the rider's input and its weight η."""
    setup = step.setup
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
    )


def limited_authority(step: StepInput, authority: Authority, recovery: RecoveryAction) -> Authority:
    """Reduce η where the chair takes over: during recovery and at the end of the path."""
    route, parameters = step.memory.route, step.setup.authority
    if step.request.mode is not Mode.SHARED or route is None:
        return authority
    if recovery.takes_over:
        # A chair at rest must not set off against a stick that is pulled back.
        if authority.deflection[0] <= -parameters.stop_deflection:
            return authority
        return replace(authority, eta=0.0)
    if authority.yields:
        return authority
    return sharing.limit_authority(authority, route.path.length - route.progress, parameters)


class Navigator:
    """The pipeline from an observation to the command for the wheels.

    It holds nothing that changes: state that a stage needs again comes back in the last tick.

    Args:
        setup: map, robot and parts.
    """

    def __init__(self, setup: NavigatorSetup) -> None:
        self.setup = setup
        self._changes = NO_CHANGES
        self.walls = distance_field(setup.grid)
        closed = with_keepout_walls(setup.grid, setup.filters)
        self.beams = beam_map(setup.grid, self.walls)
        self.openable = setup.grid.occupied() & ~closed_cells(setup.filters, setup.grid)
        self.barriers = self.walls if closed is setup.grid else distance_field(closed)
        self.destinations = destination_inference(
            setup.grid,
            setup.filters,
            setup.places,
            setup.robot.inscribed_radius,
            setup.destinations,
        )

    def remembering(self, changes: MapChanges) -> Navigator:
        """Return the same navigator with contradictions to the map that earlier rides have seen."""
        out = copy.copy(self)
        out._changes = changes
        return out

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
        checked = self._check(observation, request, last)
        if isinstance(checked, Tick):
            return checked
        stopwatch.lap("health")

        step = checked.step
        world = update_world_model(step, self.walls, self.barriers, self.openable, stopwatch)
        step = with_floor_limit(with_opening_speed(step, world), world.floor)
        sharing = self._share(step)
        stopwatch.lap("sharing")

        # Recovery, if the ride makes no progress although it should.
        arrived = has_arrived(step, last)
        hold = arrived or self._holds(step.request, sharing.authority)
        recovery = update_recovery(step, world, sharing.authority, hold=hold)
        authority = limited_authority(step, sharing.authority, recovery.action)

        course = plan_path_and_reference(step, world, authority, recovery.action, hold=hold)
        stopwatch.lap("planning")
        motion = self._motion(
            step,
            world,
            authority,
            course,
            recovery=recovery.action,
            last=last,
            arrived=arrived,
        )
        stopwatch.lap("control")

        # The gate has the last word.
        decision = self._decide(step, world, motion, checked.health, recovery.action)
        stopwatch.lap("safety")
        results = StageResults(
            checked=checked,
            world=world,
            sharing=sharing,
            authority=authority,
            arrived=arrived,
            recovery=recovery,
            motion=motion,
            decision=decision,
        )
        return tick_of(observation, request, results, stopwatch.laps)

    def _check(
        self, observation: Observation, request: Request, last: Tick | None
    ) -> CheckedInput | Tick:
        """Check the input; if it is not trusted, return the tick that stops the chair."""
        setup, memory = self.setup, last.memory if last else Memory()
        # Input that is invalid or too old stops the chair before any stage uses it.
        fault, gate_state = check_input(observation, request, setup.robot, memory.gate, setup.gate)
        if fault is not None:
            return stopped_by_input(observation, request, fault, gate_state, last)
        # Redundant input that does not agree slows the chair, or stops it.
        before = memory.health or HealthState(changes=self._changes)
        people = last.people.mean if last else None
        health, health_state = monitor(
            observation, request, setup.robot, self.beams, before, setup.health, people=people
        )
        memory = replace(memory, health=health_state)
        if health.stop is not None:
            memory, watched = keep_watching(setup, self.walls, observation, health, memory)
            return stopped_by_health(
                observation, request, health, gate_state, memory, last, people=watched
            )
        limit = min(request.speed_limit, health.speed_limit)
        limited = replace(request, speed_limit=limit)
        placed = registered(observation, health_state, setup.robot, setup.health)
        step = self._step_input(placed, _with_mode(limited), memory, last)
        return CheckedInput(step, gate_state, health, health_state)

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

    def _share(self, step: StepInput) -> Sharing:
        """Weigh the rider's input, and infer destinations if the rider has chosen none."""
        authority, authority_state = rider_authority(step)
        authority, yielding = with_yielding(step, authority)
        belief, belief_state = inferred_destinations(self.destinations, step, authority)
        return Sharing(authority, authority_state, yielding, belief, belief_state)

    def _holds(self, request: Request, authority: Authority) -> bool:
        """Check that the chair need not make progress: the rider drives or requests a stop."""
        return (
            request.mode.rider_drives
            or authority.wants_stop
            or authority.yields
            or self.setup.speed_limit(request) <= 0.0
        )

    def _motion(
        self,
        step: StepInput,
        world: WorldModel,
        authority: Authority,
        course: PathAndReference,
        *,
        recovery: RecoveryAction,
        last: Tick | None,
        arrived: bool,
    ) -> Motion:
        """Compute the command: that of a rider who is helped with steering, or of the planner."""
        mode, steering = step.request.mode, None
        if mode is Mode.ASSISTED:
            intent, steering = intent_of(step, world, authority)
            motion = helped_motion(step, world, authority, course, intent, last)
            return motion._replace(steering=steering)
        if mode is Mode.SHARED:
            intent, steering = intent_of(step, world, authority)
            course = replace(course, rider_inputs=rider_inputs(authority, intent))
        plan, command = self._plan(
            step, world, authority, course, recovery=recovery, last=last, arrived=arrived
        )
        if plan is not None and authority.yields:
            motion = helped_motion(step, world, authority, course, intent, last)
            return motion._replace(steering=steering, own=plan)
        return Motion(plan, command, course, steering, own=plan)

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
            return None, Command(reason=Reason.ARRIVED if arrived else Reason.STICK_BACK)
        if arrived or course.holds:
            begin = step.observation.twist if last is None else last.decision.twist
            twist = gentle_stop(setup.robot, begin)
            waits = recovery.reason(stands=True) or Reason.WAITING
            return None, Command(twist=twist, reason=Reason.ARRIVED if arrived else waits)
        if course.shared is None:
            reason = course.failure.reason if course.failure else Reason.PLANNING
            return None, Command(reason=reason)
        problem = self._local_problem(step, world, authority, course, course.shared, recovery)
        try:
            plan = setup.local_planner.plan(problem, last.plan if last else None)
        except ControlError:
            return None, Command(reason=Reason.SOLVER_FAILED)
        reported = None if plan.brief else plan.reason
        return plan, Command(twist=plan.command, reason=reported, urgent=plan.urgent)

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
        return local_walls(
            setup.grid, self.barriers, live, world.openings.opened, pose[:2], setup.window
        )

    def _decide(
        self,
        step: StepInput,
        world: WorldModel,
        motion: Motion,
        health: Health,
        recovery: RecoveryAction,
    ) -> Decision:
        """Decide on the command, with the reason that matters most."""
        decision = decide(
            step,
            world,
            motion.command,
            by_rider=motion.by_rider,
            barriers=self.barriers,
            map_walls=self.walls,
        )
        decision = with_recovery_reason(decision, motion.plan, step.observation.twist, recovery)
        return with_health_reason(decision, health)


def _with_mode(request: Request) -> Request:
    """Shared control without a destination is help with steering."""
    if request.mode is Mode.SHARED and np.isnan(request.goal).any():
        return replace(request, mode=Mode.ASSISTED)
    return request
