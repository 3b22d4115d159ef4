"""The pipeline: one observation in, one tick out; the only place where the stages meet."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats
from cohelm.control import LocalProblem
from cohelm.errors import ControlError
from cohelm.maps import DistanceField, distance_field
from cohelm.messages import (
    Authority,
    Decision,
    LocalPlan,
    Mode,
    Observation,
    People,
    Reason,
    Request,
)
from cohelm.navigation.course import Course, lay_course
from cohelm.navigation.recovery import Recovery
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.sight import Sight, see
from cohelm.navigation.situation import explained, recover
from cohelm.navigation.standing import closed_but_for
from cohelm.navigation.stopwatch import Stopwatch
from cohelm.navigation.tick import Memory, Tick
from cohelm.navigation.walls import walls_about
from cohelm.navigation.zones import limited, walled
from cohelm.safety import GateState, check_input, gate, stop
from cohelm.sharing import authority, docked


class Navigator:
    """From what is known to what the wheels do.

    It holds nothing that changes: what a stage needs of the past comes back in the last tick.

    Args:
        setup: a map, a robot and the parts.
    """

    def __init__(self, setup: NavigatorSetup) -> None:
        self.setup = setup
        self.walls = distance_field(setup.grid)
        closed = walled(setup.grid, setup.filters)
        self.barriers = self.walls if closed is setup.grid else distance_field(closed)

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
        asked = request
        request = limited(
            asked,
            setup.filters,
            setup.robot,
            observation,
            memory.route if memory else None,
            setup.zones,
        )
        seen = see(
            setup, self.walls, self.barriers, observation, request, memory=memory, watch=watch
        )
        hand, hand_state = authority(
            observation,
            request.profile,
            setup.robot,
            steps=setup.local_planner.steps,
            step=setup.local_planner.step,
            speed_limit=setup.speed_limit(request),
            memory=memory.authority if memory else None,
            parameters=setup.authority,
        )
        watch.lap("sharing")
        arrived = self._arrived(observation, request, last)
        rests = arrived or self._rests(request, hand)
        remedy, recovering, behind = recover(
            setup, observation, request, seen, hand, memory, rests=rests
        )
        hand = self._lent(hand, request, remedy, memory)
        course = lay_course(
            setup, observation, request, seen, hand, memory, remedy=remedy, rests=rests
        )
        watch.lap("planning")
        plan, wanted = self._want(
            observation,
            request,
            seen,
            hand,
            course,
            remedy=remedy,
            last=last,
            arrived=arrived,
        )
        watch.lap("control")
        decision = self._decide(observation, request, seen, wanted)
        decision = explained(decision, plan, observation.twist, remedy)
        watch.lap("safety")
        return Tick(
            observation=observation,
            request=asked,
            decision=decision,
            memory=Memory(
                gate=gate_state,
                perception=seen.perception,
                predictor=seen.predictor,
                obstacles=seen.layer,
                beyond=seen.beyond,
                crowding=seen.crowding,
                route=course.route,
                refusal=course.refusal,
                progress=course.progress,
                behind=behind,
                recovery=recovering,
                authority=hand_state,
            ),
            sensing=seen.sensing,
            people=seen.people,
            groups=seen.groups,
            predictions=seen.predictions,
            spaces=seen.spaces,
            path=course.route.path if course.route else None,
            reference=course.reference,
            authority=hand,
            recovery=remedy,
            shared=course.shared,
            plan=plan,
            trouble=course.refusal.trouble if course.refusal else "",
            arrived=arrived,
            durations=MappingProxyType(watch.laps),
        )

    def _arrived(self, observation: Observation, request: Request, last: Tick | None) -> bool:
        """Within the tolerance; once there, still there a little beyond it.

        A chair that comes hardly any nearer has arrived a little before: turning about for the last
        centimetres helps nobody.
        """
        setup = self.setup
        away = float(np.hypot(*(request.goal - observation.pose[:2])))
        stays = (
            last is not None and last.arrived and np.array_equal(last.request.goal, request.goal)
        )
        slow = float(np.hypot(*observation.twist[:2])) < setup.goal_crawl
        if not stays and slow and last is not None:
            return bool(away <= max(setup.goal_reach, setup.goal_tolerance))
        return bool(away <= setup.goal_tolerance * (2.0 if stays else 1.0))

    def _rests(self, request: Request, hand: Authority) -> bool:
        """The chair is not to get on: the rider steers alone, or wants it to stand."""
        alone = request.mode in {Mode.MANUAL, Mode.ASSISTED}
        return alone or hand.wants_stop or self.setup.speed_limit(request) <= 0.0

    def _lent(
        self, hand: Authority, request: Request, remedy: Recovery, memory: Memory | None
    ) -> Authority:
        """What is left of the hand's share where the chair must find its way itself."""
        way = memory.route if memory else None
        if request.mode is not Mode.SHARED or way is None:
            return hand
        if remedy.leads:
            if hand.deflection[0] <= -self.setup.authority.against:
                return hand  # a chair that stands must not set off against a pull
            return dataclasses.replace(hand, eta=0.0)
        return docked(hand, way.path.length - way.progress, self.setup.authority)

    def _want(
        self,
        observation: Observation,
        request: Request,
        seen: Sight,
        hand: Authority,
        course: Course,
        *,
        remedy: Recovery,
        last: Tick | None,
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
            reason = course.refusal.reason if course.refusal else Reason.PLANNING
            return None, _Wanted(reason=reason)
        limit = self.setup.speed_limit(request)
        profile, walls = request.profile, seen.walls
        if remedy.side != "none":
            profile = profile.model_copy(update={"passing_side": remedy.side})
            walls = self._barred(observation.pose, seen, remedy)
        problem = LocalProblem(
            time=observation.time,
            robot=self.setup.robot,
            pose=observation.pose,
            twist=observation.twist,
            reference=course.shared,
            people=seen.people,
            predictions=seen.predictions,
            spaces=seen.spaces,
            walls=walls,
            authority=hand,
            profile=profile,
            speed_limit=min(limit, self.setup.progress.creep) if remedy.squeezes else limit,
            stalled=remedy.squeezes,
            reverses=remedy.reverses,
            late=observation.late,
        )
        try:
            plan = self.setup.local_planner.plan(problem, last.plan if last else None)
        except ControlError:
            return None, _Wanted(reason=Reason.SOLVER_FAILED)
        return plan, _Wanted(twist=plan.command, reason=plan.reason, urgent=plan.urgent)

    def _barred(self, pose: Floats, seen: Sight, remedy: Recovery) -> DistanceField:
        """The walls, with the side on which the rider does not want to pass closed."""
        setup, below = self.setup, self.setup.replanning.standing
        live = closed_but_for(remedy.side, seen.live, setup.grid, seen.people, pose, below)
        return walls_about(setup.grid, self.barriers, live, pose[:2], setup.window)

    def _decide(
        self, observation: Observation, request: Request, seen: Sight, wanted: _Wanted
    ) -> Decision:
        """The gate's word; the planner's own reason where the gate has none."""
        if wanted.twist is None:
            return stop(wanted.reason or Reason.PLANNING)
        decision = self._gated(wanted.twist, observation, request, seen, seen.walls)
        if wanted.urgent:
            decision = dataclasses.replace(decision, twist=np.zeros(3), emergency=True)
        if decision.reason is Reason.BLOCKED and self._only_rules(
            wanted, observation, request, seen
        ):
            return dataclasses.replace(decision, reason=Reason.KEEPOUT)
        if decision.reason is None and wanted.reason is not None:
            return dataclasses.replace(decision, reason=wanted.reason)
        return decision

    def _only_rules(
        self, wanted: _Wanted, observation: Observation, request: Request, seen: Sight
    ) -> bool:
        """Whether nothing but a keepout zone is in the way of the wanted twist."""
        if self.barriers is self.walls or wanted.twist is None:
            return False
        setup = self.setup
        bodily = walls_about(setup.grid, self.walls, seen.live, observation.pose[:2], setup.window)
        decision = self._gated(wanted.twist, observation, request, seen, bodily)
        return decision.reason is not Reason.BLOCKED

    def _gated(
        self,
        twist: Floats,
        observation: Observation,
        request: Request,
        seen: Sight,
        walls: DistanceField,
    ) -> Decision:
        return gate(
            twist,
            observation,
            request,
            self.setup.robot,
            walls=walls,
            people=seen.people,
            predictions=seen.predictions,
            parameters=self.setup.gate,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wanted:
    """A twist, or None and why."""

    twist: Floats | None = None
    reason: Reason | None = None
    urgent: bool = False
    """To be stood as hard as the chair can brake."""


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
