"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11).

One objective in seconds judges every trajectory, see ``objective``: sampled arcs, the last plan,
results of the SQP, and gentle stops. Its barriers are soft, and their price is no proof of safety:
``verification`` accepts or rejects.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import replace
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.candidates import (
    BRAKING,
    CHOICES,
    PREVIOUS,
    STOPPING,
    Candidate,
    Choice,
    PlanningCycle,
    cheapest_of_different_classes,
)
from cohelm.control.objective_tables import TERMS
from cohelm.control.optimal_control import RELAXED_SLACK, OptimalControl
from cohelm.control.planner_memory import (
    EXPIRED,
    PlannerMemory,
    present_acceleration,
    recent_paces,
    recent_speeds,
    remembered,
    unexpired_memory,
)
from cohelm.control.rider_motion import disagreement
from cohelm.control.sampling import Sampling
from cohelm.control.stack import Terms
from cohelm.control.terms import ExtraTerm
from cohelm.control.terms.extra import checked_terms
from cohelm.control.trajectories import PLANNED_BRAKING
from cohelm.control.unaware import times_on_course
from cohelm.control.validation import check_problem
from cohelm.control.verification import Verification
from cohelm.control.warm_start import estimate_current_input, shifted_plan
from cohelm.messages import LocalPlan, Reason, Status
from cohelm.robots.clearance import Clearance

_SPEED_SHARES = (0.6, 0.3)
"""Shares of its speed at which the best trajectory is tried if none is verified."""

_STAND = 0.4
"""Shortest stand, s: a shorter one is felt as a jolt."""
CONTACT_WAIT = 1.0
"""Standstill after a walking person has touched the robot, s."""
_LATE = 0.05
"""Lateness from which one candidate is improved by one program, s: a tick."""
_RESAMPLE_ABOVE = 1.0
"""With one candidate: increase of the plan's cost above which others are sampled, s."""


class SsMpcDcbf:
    """The paper's local planner: people and walls are barriers of a predictive controller.

    In each cycle: sample trajectories; let the SQP improve the cheapest ones of different homotopy
    classes; take the cheapest one that verification accepts, unimproved ones included. Leaving the
    committed class has a cost (see ``planner_memory``). If none is accepted, try the best one at
    reduced speed, then stops, the gentlest first. With ``candidates = 1`` only the last plan is
    improved, and others are sampled only if it fails verification or becomes expensive.

    Args:
        parameters: of the planner.
        extra_terms: user-defined cost terms, see ``terms.extra``; invalid ones raise ConfigError.
    """

    class Parameters(Model):
        """Horizon, budget, terms, clearance and verification; the paper gives no figures."""

        steps: int = Field(24, ge=3, le=100)
        """N, steps of the plan, which the SQP changes."""
        step: float = Field(0.16, gt=0.0, le=1.0)
        """Δt, s; longer than a tick, so the last plan is shifted by interpolation."""
        candidates: int = Field(2, ge=1, le=8)
        """Trajectories that the SQP improves. With one it is the last plan, as in the paper:
        trajectories are sampled only without a plan, if it fails verification or costs much more
        than before, or if the ride is stalled."""
        iterations: int = Field(2, ge=1, le=50)
        """Quadratic programs per candidate: the budget, the same on every machine."""
        clearance: Clearance = Clearance()
        terms: Terms = Terms()
        choice: Choice = Choice()
        sampling: Sampling = Sampling()
        verification: Verification = Verification()

    def __init__(
        self, parameters: Parameters | None = None, extra_terms: Sequence[ExtraTerm] = ()
    ) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.sampling.steps(p.step, p.steps), p.step
        self.clearance = p.clearance
        terms = checked_terms(extra_terms, (*TERMS, *CHOICES))
        self.control = OptimalControl(p.terms, p.clearance, extra_terms=terms)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        p = self.parameters
        check_problem(problem)
        cycle = self._prepare(problem, previous)
        if problem.time - problem.last_contact < CONTACT_WAIT:
            return self._stop(cycle, cycle.braking(), 0)
        stood = problem.time - cycle.stands_since
        if 0.0 <= stood < _STAND and not problem.stalled:
            return self._stop(cycle, cycle.braking(), 0)
        tail = None if cycle.memory is None else cycle.memory.tail
        warm = shifted_plan(cycle.mpc_problem, previous, cycle.current_input, tail=tail)
        trusted = previous is not None and previous.status is not Status.STOP
        iterations = 0
        if p.candidates == 1 and warm is not None and trusted and not problem.stalled:
            candidates, iterations = self._continue(cycle, warm)
            for candidate in candidates:
                if cycle.accepts(candidate):
                    return self._plan_or_stop(cycle, candidate, iterations, resampled=False)
        return self._resample(cycle, warm, trusted=trusted, iterations=iterations)

    def _prepare(self, problem: LocalProblem, previous: LocalPlan | None) -> PlanningCycle:
        """Compute everything that the stages of one plan share."""
        p = self.parameters
        memory = unexpired_memory(previous, problem.time)
        current_input = estimate_current_input(problem, previous)
        available = len(problem.reference.speeds) - 1
        mpc_problem = problem.truncated(p.steps)
        speeds = recent_speeds(problem.people, memory, problem.time)
        paces = recent_paces(problem.people, memory, problem.time)
        courses = times_on_course(problem, memory)
        return PlanningCycle(
            problem=problem,
            prepared=self.control.prepare(
                problem,
                current_input,
                planned=min(p.steps, available),
                steps=p.sampling.steps(problem.reference.step, available),
                wall_margin=p.verification.wall_margin_of(problem),
                acceleration=present_acceleration(memory, problem.time, current_input),
            ),
            current_input=current_input,
            mpc_problem=mpc_problem,
            memory=memory,
            person_speeds=speeds,
            person_paces=paces,
            person_courses=courses,
            verifier=p.verification.verifier(
                mpc_problem, self.clearance, current_input, speeds, courses, paces
            ),
            choice=p.choice,
        )

    def _continue(self, cycle: PlanningCycle, warm: Trajectory) -> tuple[list[Candidate], int]:
        """Improve the last plan without sampling.

        Returns:
            The plan and the number of quadratic programs. The list is empty if its cost has risen
            by more than ``_RESAMPLE_ABOVE``.
        """
        [last] = cycle.evaluate([warm.inputs], [PREVIOUS])
        improved, programs = self._improve(cycle, [last])
        lowest = -np.inf if cycle.memory is None else cycle.memory.lowest_cost
        limit = lowest + _RESAMPLE_ABOVE
        return [each for each in (*improved, last) if each.score <= limit], programs

    def _resample(
        self, cycle: PlanningCycle, warm: Trajectory | None, *, trusted: bool, iterations: int
    ) -> LocalPlan:
        """Choose among the last plan and new samples; brake if verification accepts none.

        Args:
            cycle: the planning cycle.
            warm: the last plan from now on, if any.
            trusted: use it unimproved as well; a stop is only improved.
            iterations: quadratic programs solved before.
        """
        found = cycle.sample(self.parameters.sampling, warm)
        count = 1 if self._is_late(cycle) else self.parameters.candidates
        improved, programs = self._improve(cycle, cheapest_of_different_classes(found, count))
        usable = found if trusted else [each for each in found if each.origin != PREVIOUS]
        ranked = sorted([*improved, *usable], key=lambda each: each.score)
        chosen = self._first_verified(cycle, ranked)
        return self._plan_or_stop(cycle, chosen, iterations + programs, resampled=True)

    def _plan_or_stop(
        self, cycle: PlanningCycle, chosen: Candidate | None, iterations: int, *, resampled: bool
    ) -> LocalPlan:
        """Plan of the chosen candidate, with its angle to the rider's motion; else a stop."""
        if chosen is None:
            return self._stop(cycle, cycle.braking(), iterations, urgent=True)
        if chosen.origin in {STOPPING, BRAKING}:
            return self._stop(cycle, chosen, iterations)
        plan = self._as_plan(cycle, chosen, iterations, resampled=resampled)
        return replace(plan, disagreement=disagreement(cycle, chosen))

    def _improve(self, cycle: PlanningCycle, seeds: list[Candidate]) -> tuple[list[Candidate], int]:
        """Return (the seeds after the SQP, number of quadratic programs)."""
        iterations = 1 if self._is_late(cycle) else self.parameters.iterations
        inputs, programs = [], 0
        for seed in seeds:
            solved, count = cycle.prepared.solve(seed.inputs, iterations=iterations)
            inputs.append(solved)
            programs += count
        return cycle.evaluate(inputs, [seed.origin for seed in seeds]) if seeds else [], programs

    def _first_verified(self, cycle: PlanningCycle, ranked: list[Candidate]) -> Candidate | None:
        """The cheapest candidate that verification accepts; None: brake hard.

        If none is accepted, the best one at reduced speed, then the gentlest stop that stands in
        time, then the hardest one that helps.
        """
        for candidate in ranked:
            if cycle.accepts(candidate):
                return candidate
        best = ranked[0] if ranked else None
        if best is not None:
            for share in _SPEED_SHARES:
                slower = cycle.slowed(best, share)
                if cycle.accepts(slower):
                    return slower
        # The nearer the person, the harder the stop: a harder one needs to keep less of the gap.
        verifier = cycle.verifier
        stops = [*cycle.stops(best), cycle.braking(PLANNED_BRAKING)]
        helpful = []
        for candidate, share in zip(stops, np.linspace(1.0, 0.0, len(stops)), strict=True):
            trajectory = cycle.trajectory(candidate)
            if verifier.brakes_help(trajectory, float(share)):
                if verifier.stands_in_time(trajectory):
                    return candidate
                helpful.append(candidate)
        if not helpful or verifier.only_hard_braking_helps(cycle.trajectory(helpful[-1])):
            return None
        return helpful[-1]

    def _is_late(self, cycle: PlanningCycle) -> bool:
        return cycle.problem.late > _LATE

    def _as_plan(
        self,
        cycle: PlanningCycle,
        chosen: Candidate,
        iterations: int,
        *,
        resampled: bool = False,
    ) -> LocalPlan:
        trajectory, prepared = cycle.trajectory(chosen), cycle.prepared
        names = (*self.control.names, *CHOICES)
        lowest = np.inf if resampled or cycle.memory is None else cycle.memory.lowest_cost
        memory = PlannerMemory(
            time=cycle.problem.time,
            path_side=int(chosen.passing_sides[0]),
            person_id=cycle.problem.people.id,
            person_sides=chosen.passing_sides[1:],
            person_speeds=cycle.person_speeds,
            person_paces=cycle.person_paces,
            person_courses=cycle.person_courses,
            tail=chosen.inputs[cycle.steps :],
            input_time=cycle.problem.time,
            current_input=cycle.current_input,
            stands_since=cycle.stands_since,
            lowest_cost=min(chosen.cost, lowest),
        )
        return LocalPlan(
            time=cycle.problem.time,
            step=trajectory.step,
            command=cycle.problem.robot.motion_model.twist(trajectory.inputs[0]),
            poses=trajectory.poses,
            inputs=trajectory.inputs,
            status=Status.RELAXED if chosen.slack > RELAXED_SLACK else Status.OK,
            costs=MappingProxyType(dict(zip(names, chosen.by_term.tolist(), strict=True))),
            smallest_barrier=prepared.barrier(chosen.inputs),
            slack=chosen.slack,
            iterations=iterations,
            candidate=chosen.origin,
            memory=memory,
        )

    def _stop(
        self, cycle: PlanningCycle, stop: Candidate, iterations: int, *, urgent: bool = False
    ) -> LocalPlan:
        """A stop, with the reason; the commitment of the last plan is kept."""
        plan = self._as_plan(cycle, stop, iterations)
        memory: Any = plan.memory
        if cycle.memory is not None:
            people, before = cycle.problem.people, cycle.memory
            committed = int(cycle.problem.time - before.time <= EXPIRED)
            memory = replace(
                memory,
                time=before.time,
                path_side=committed * before.path_side,
                person_sides=committed * remembered(before, people, before.person_sides),
                lowest_cost=before.lowest_cost,
            )
        # a chair that rolls on has slowed down, and not stopped
        stands = cycle.stands
        return replace(
            plan,
            status=Status.STOP,
            reason=Reason.NO_SAFE_PLAN,
            brief=not (urgent or stands),
            urgent=urgent and not stands,
            memory=memory,
        )
