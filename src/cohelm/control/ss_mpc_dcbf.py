"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11).

Two objectives judge a trajectory. **The SQP refines; the sampler's cost ranks**:

======================  ===================================  =======================================
idea                    SQP (``control.terms``), N steps     sampler (``sampling.rollout``), seconds
======================  ===================================  =======================================
progress                ``track_reference``, ``progress``    ``final_delay``, ``mean_delay``
offset from the path    ``track_reference``                  ``path_distance``, ``final_heading``
turning, acceleration   ``input_effort``, ``smooth_input``,  ``turning``, ``acceleration``
                        ``comfort``
contact with people     ``bodies``, soft barrier             ``contact``, all hypotheses by weight
personal space          ``social_space``, soft barrier       ``personal_space``
groups                  ``group_space``, soft barrier        ``group_space``
walls                   ``wall_clearance``, soft barrier     ``wall``, and a stop before contact
passing side, class     none: a local method keeps both      ``passing_side``, ``switching_cost``,
                                                             ``exploration_cost``
======================  ===================================  =======================================

Slack and either cost are no proof of safety: ``verification`` accepts or rejects.
"""

from __future__ import annotations

import dataclasses
from itertools import chain
from types import MappingProxyType

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.candidate_evaluation import (
    PREVIOUS,
    EvaluatedCandidate,
    PlanningCycle,
    cheapest_of_different_classes,
)
from cohelm.control.planner_memory import PlannerMemory, last_contact, unexpired_memory
from cohelm.control.sampling import TrajectorySampler
from cohelm.control.sqp import RELAXED_SLACK, OptimalControl, Solution
from cohelm.control.terms import (
    GroupBarrier,
    InputEffort,
    InputLimits,
    PathProgress,
    PersonBarrier,
    SeatComfort,
    SmoothInput,
    SocialSpaceBarrier,
    TrackReference,
    WallBarrier,
)
from cohelm.control.validation import check_problem
from cohelm.control.verification import Verification
from cohelm.control.warm_start import estimate_current_input, shifted_plan, with_reference_towards
from cohelm.messages import LocalPlan, Reason, Status


class SsMpcDcbf:
    """The paper's local planner: tracks the reference with people and walls as barriers.

    In each cycle: sample candidate trajectories; refine a few of them, the last plan among them, by
    the SQP; take the cheapest one that verification accepts, unrefined ones included. Leaving the
    committed homotopy class has a cost (see ``planner_memory``). If none is accepted, try the best
    one at reduced speed, and finally brake with a reason. With ``candidates = 1`` only the last
    plan is refined, and others are sampled only if it fails verification or becomes expensive.
    """

    class Parameters(Model):
        """Steps, budget, terms and constraints; the paper gives no figures, these are assumed."""

        steps: int = Field(25, ge=3, le=100)
        """N, steps of the SQP and of the plan."""
        step: float = Field(0.16, gt=0.0, le=1.0)
        """Δt, s; longer than a tick, so the last plan is shifted by interpolation."""
        candidates: int = Field(2, ge=1, le=8)
        """Trajectories that the SQP refines. With one it is the last plan, as in the paper:
        candidates are sampled only without a plan, if it fails verification, if the ride is
        stalled, or above ``resample_above``."""
        resample_above: float = Field(1.0, ge=0.0, le=100.0)
        """With one candidate: increase of the plan's cost above which candidates are sampled, s."""
        iterations: int = Field(2, ge=1, le=50)
        """Quadratic programs per candidate: the budget, the same on every machine."""
        switching_cost: float = Field(1.5, ge=0.0, le=100.0)
        """Cost of leaving the committed homotopy class, s."""
        exploration_cost: float = Field(0.2, ge=0.0, le=100.0)
        """Cost of replacing the last plan by a sampled trajectory, s."""
        polishing_gain: float = Field(1.0, ge=0.0, le=100.0)
        """Advantage of refined trajectories, s: one that the SQP makes more expensive by more than
        this is used unrefined, and an unrefined one must be cheaper by this."""
        seed_tracking: float = Field(0.5, ge=0.0, le=1.0)
        """Share of the candidate in the reference that the SQP tracks when it refines it."""
        late: float = Field(0.05, gt=0.0, le=1.0)
        """Lateness from which one candidate is refined by one program, s: a tick."""
        speed_shares: tuple[float, ...] = (0.6, 0.3)
        """Shares of its speed at which the best trajectory is tried if none is verified."""
        contact_wait: float = Field(1.0, ge=0.0, le=10.0)
        """Standstill after a walking person has touched the robot, s."""
        sampling: TrajectorySampler.Parameters = TrajectorySampler.Parameters(
            count=160, perturbations=40, rounds=1
        )
        verification: Verification = Verification()
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        comfort: SeatComfort.Parameters = SeatComfort.Parameters()
        progress: PathProgress.Parameters = PathProgress.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallBarrier.Parameters = WallBarrier.Parameters()
        bodies: PersonBarrier.Parameters = PersonBarrier.Parameters(min_probability=1.0)
        social_space: SocialSpaceBarrier.Parameters = SocialSpaceBarrier.Parameters()
        group_space: GroupBarrier.Parameters = GroupBarrier.Parameters()

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = max(p.steps, round(p.sampling.horizon / p.step)), p.step
        self.sampler = TrajectorySampler(p.sampling)
        self.control = OptimalControl(
            costs=(
                TrackReference(p.track_reference),
                InputEffort(p.input_effort),
                SmoothInput(p.smooth_input),
                SeatComfort(p.comfort),
                PathProgress(p.progress),
            ),
            constraints=(
                InputLimits(p.input_limits),
                WallBarrier(p.wall_clearance),
                PersonBarrier(p.bodies),
                SocialSpaceBarrier(p.social_space),
                GroupBarrier(p.group_space),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        p = self.parameters
        check_problem(problem)
        cycle = self._prepare(problem, previous)
        if problem.time - cycle.last_contact < p.contact_wait:
            return self._stop(cycle, 0)
        tail = None if cycle.memory is None else cycle.memory.tail
        warm = shifted_plan(cycle.mpc_problem, previous, cycle.current_input, tail=tail)
        trusted = previous is not None and previous.status is not Status.STOP
        iterations = 0
        if p.candidates == 1 and warm is not None and trusted and not problem.stalled:
            candidates, iterations = self._continue(cycle, warm)
            for candidate in candidates:
                if p.verification.passes(cycle.mpc_problem, candidate.trajectory):
                    return self._as_plan(cycle, candidate, iterations)
        return self._resample(cycle, warm, trusted=trusted, iterations=iterations)

    def _prepare(self, problem: LocalProblem, previous: LocalPlan | None) -> PlanningCycle:
        """Compute everything that the stages of one plan share."""
        p = self.parameters
        memory = unexpired_memory(previous, problem.time)
        current_input = estimate_current_input(problem, previous)
        return PlanningCycle(
            problem=problem,
            mpc_problem=problem.truncated(p.steps),
            sampler=self.sampler.prepare(problem, current_input),
            current_input=current_input,
            memory=memory,
            last_contact=last_contact(problem, memory),
            switching_cost=p.switching_cost,
            exploration_cost=p.exploration_cost,
        )

    def _continue(
        self, cycle: PlanningCycle, warm: Trajectory
    ) -> tuple[list[EvaluatedCandidate], int]:
        """Refine the last plan without sampling.

        Returns:
            The plan, refined or as it was, and the number of quadratic programs. The list is empty
            if its cost has risen by more than ``resample_above``.
        """
        n = cycle.steps
        seed = Trajectory(
            step=warm.step,
            poses=warm.poses[: n + 1],
            inputs=warm.inputs[:n],
            current_input=cycle.current_input,
        )
        solution = self._solve(cycle, seed)
        full_inputs = np.vstack([solution.trajectory.inputs, warm.inputs[n:]])
        [candidate] = cycle.evaluate([full_inputs], [PREVIOUS])
        previous_cost = -np.inf if cycle.memory is None else cycle.memory.lowest_cost
        limit = previous_cost + self.parameters.resample_above
        candidates = [candidate.with_solution(solution)]
        if candidate.selection_cost > limit:  # the cause may be the refinement
            candidates = cycle.evaluate([warm.inputs], [PREVIOUS])
        affordable = [each for each in candidates if each.selection_cost <= limit]
        return affordable, solution.iterations

    def _resample(
        self, cycle: PlanningCycle, warm: Trajectory | None, *, trusted: bool, iterations: int
    ) -> LocalPlan:
        """Choose among the last plan and new samples; brake if verification accepts none.

        Args:
            cycle: the planning cycle.
            warm: the last plan from now on, if any.
            trusted: use it unrefined as well; a stop is only refined.
            iterations: quadratic programs solved before.
        """
        sampled = cycle.sample(warm)
        previous = [] if warm is None else cycle.evaluate([warm.inputs], [PREVIOUS])
        count = 1 if self._is_late(cycle) else self.parameters.candidates
        seeds = cheapest_of_different_classes([*previous, *sampled], count)
        refined, programs = self._refine(cycle, seeds)
        ranked = self._rank(refined, [*(previous if trusted else []), *sampled])
        chosen = self._first_verified(cycle, ranked)
        if chosen is None:
            return self._stop(cycle, iterations + programs)
        return self._as_plan(cycle, chosen, iterations + programs, resampled=True)

    def _refine(
        self, cycle: PlanningCycle, seeds: list[EvaluatedCandidate]
    ) -> tuple[list[EvaluatedCandidate], int]:
        """Return (the seeds after the SQP, cheapest first; number of quadratic programs)."""
        solutions = [self._solve(cycle, seed.trajectory) for seed in seeds]
        full_inputs = [
            np.vstack([solution.trajectory.inputs, seed.tail])
            for seed, solution in zip(seeds, solutions, strict=True)
        ]
        evaluated = cycle.evaluate(full_inputs, [seed.origin for seed in seeds])
        out = []
        for seed, candidate, solution in zip(seeds, evaluated, solutions, strict=True):
            limit = seed.selection_cost + self.parameters.polishing_gain
            worse = candidate.selection_cost > limit
            out.append(seed if worse else candidate.with_solution(solution))
        out.sort(key=lambda each: each.selection_cost)
        return out, sum(solution.iterations for solution in solutions)

    def _rank(
        self, refined: list[EvaluatedCandidate], unrefined: list[EvaluatedCandidate]
    ) -> list[EvaluatedCandidate]:
        """Sort by selection cost; an unrefined candidate must be cheaper by ``polishing_gain``."""
        gain = self.parameters.polishing_gain
        costs = [
            *(each.selection_cost for each in refined),
            *(each.selection_cost + gain for each in unrefined),
        ]
        candidates = [*refined, *unrefined]
        return [candidates[k] for k in np.argsort(costs, kind="stable")]

    def _first_verified(
        self, cycle: PlanningCycle, ranked: list[EvaluatedCandidate]
    ) -> EvaluatedCandidate | None:
        """The first candidate that verification accepts, or the best one at reduced speed."""
        p = self.parameters
        slower = (cycle.slowed(best, share) for best in ranked[:1] for share in p.speed_shares)
        for candidate in chain(ranked, slower):
            if p.verification.passes(cycle.mpc_problem, candidate.trajectory):
                return candidate
        return None

    def _solve(self, cycle: PlanningCycle, seed: Trajectory) -> Solution:
        """Run the SQP from ``seed``, with the reference moved towards it."""
        p = self.parameters
        iterations = 1 if self._is_late(cycle) else p.iterations
        problem = with_reference_towards(cycle.mpc_problem, seed, p.seed_tracking)
        return self.control.solve(problem, seed, iterations=iterations)

    def _is_late(self, cycle: PlanningCycle) -> bool:
        return cycle.problem.late > self.parameters.late

    def _as_plan(
        self,
        cycle: PlanningCycle,
        chosen: EvaluatedCandidate,
        iterations: int,
        *,
        resampled: bool = False,
    ) -> LocalPlan:
        constraints = None if chosen.evaluation is None else chosen.evaluation.constraints
        evaluation = self.control.evaluate(cycle.mpc_problem, chosen.trajectory, constraints)
        lowest = np.inf if resampled or cycle.memory is None else cycle.memory.lowest_cost
        memory = PlannerMemory(
            time=cycle.problem.time,
            path_side=int(chosen.passing_sides[0]),
            person_id=cycle.problem.people.id,
            person_sides=chosen.passing_sides[1:],
            tail=chosen.tail,
            last_contact=cycle.last_contact,
            lowest_cost=min(chosen.trajectory_cost, lowest),
        )
        return LocalPlan(
            time=cycle.problem.time,
            step=chosen.trajectory.step,
            command=cycle.problem.robot.motion_model.twist(chosen.trajectory.inputs[0]),
            poses=chosen.trajectory.poses,
            inputs=chosen.trajectory.inputs,
            status=Status.RELAXED if evaluation.slack > RELAXED_SLACK else Status.OK,
            costs=MappingProxyType(dict(evaluation.costs)),
            smallest_barrier=evaluation.barrier,
            slack=evaluation.slack,
            iterations=iterations,
            candidate=chosen.origin,
            memory=memory,
        )

    def _stop(self, cycle: PlanningCycle, iterations: int) -> LocalPlan:
        """Braking, with the reason; the commitment of the last plan is kept."""
        candidate = cycle.braking()
        plan = self._as_plan(cycle, candidate, iterations)
        memory = plan.memory
        if cycle.memory is not None:
            memory = dataclasses.replace(
                cycle.memory, tail=candidate.tail, last_contact=cycle.last_contact
            )
        verification, problem = self.parameters.verification, cycle.mpc_problem
        return dataclasses.replace(
            plan,
            status=Status.STOP,
            reason=Reason.NO_SAFE_PLAN,
            urgent=verification.needs_emergency_braking(problem, cycle.current_input),
            memory=memory,
        )
