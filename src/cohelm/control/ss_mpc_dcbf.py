"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.commitment import (
    CommittedClass,
    EvaluatedCandidate,
    class_changes,
    last_contact,
    previous_commitment,
)
from cohelm.control.sampling import CandidateTrajectories, PreparedSampler, TrajectorySampler
from cohelm.control.sqp import OptimalControl, Solution
from cohelm.control.terms import (
    BodyClearance,
    GroupSpace,
    InputEffort,
    InputLimits,
    PathProgress,
    SeatComfort,
    SmoothInput,
    SocialSpace,
    TrackReference,
    WallClearance,
)
from cohelm.control.validation import validated
from cohelm.control.verification import Verification
from cohelm.control.warm_start import (
    braking_motion,
    last_input,
    limited_motion,
    shifted_plan,
    with_reference_towards,
)
from cohelm.messages import LocalPlan, Reason, Status

_PREVIOUS, _SAMPLED, _SLOWER, _BRAKING = "previous", "sampled", "slower", "braking"
"""Origins of a plan, ``LocalPlan.candidate``."""
_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""


class SsMpcDcbf:
    """The paper's local planner: tracks the reference with people and walls as barriers.

    The SQP polishes a few candidate trajectories, the last plan among them. The planner takes the
    cheapest verified one, unpolished ones included; leaving the committed homotopy class has a cost
    (see ``commitment``). Otherwise it tries the best one at reduced speed, and finally brakes with
    a reason. With ``candidates = 1`` it polishes only the last plan, and samples others only if
    that fails verification or becomes poor.
    """

    class Parameters(Model):
        """Steps, budget, terms and constraints; the paper gives no figures, these are assumed."""

        steps: int = Field(25, ge=3, le=100)
        """N, polished and planned steps."""
        step: float = Field(0.16, gt=0.0, le=1.0)
        """Δt, s; longer than a tick, so the last plan is shifted by interpolation."""
        candidates: int = Field(2, ge=1, le=8)
        """Trajectories that are polished. With one it is the last plan, as in the paper:
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
        """Value of polishing, s: a trajectory that it makes worse by more than this is used
        unpolished, and an unpolished one must be better by this."""
        seed_tracking: float = Field(0.5, ge=0.0, le=1.0)
        """Share of the candidate in the reference that its polishing tracks."""
        late: float = Field(0.05, gt=0.0, le=1.0)
        """Lateness from which one candidate is polished once, s: a tick."""
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
        wall_clearance: WallClearance.Parameters = WallClearance.Parameters()
        bodies: BodyClearance.Parameters = BodyClearance.Parameters(min_probability=1.0)
        social_space: SocialSpace.Parameters = SocialSpace.Parameters()
        group_space: GroupSpace.Parameters = GroupSpace.Parameters()

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
                WallClearance(p.wall_clearance),
                BodyClearance(p.bodies),
                SocialSpace(p.social_space),
                GroupSpace(p.group_space),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        p = self.parameters
        problem = validated(problem)
        memory = previous_commitment(previous, problem.time)
        now = last_input(problem, previous)
        call = _Call(
            problem=problem,
            near=problem.within(p.steps),
            sampler=self.sampler.prepare(problem, now),
            now=now,
            memory=memory,
            last_contact=last_contact(problem, memory),
        )
        if problem.time - call.last_contact < p.contact_wait:
            return self._stop(call, 0)
        tail = None if memory is None else memory.tail
        warm = shifted_plan(call.near, previous, call.now, tail=tail)
        trusted = previous is not None and previous.status is not Status.STOP
        iterations = 0
        if p.candidates == 1 and warm is not None and trusted and not problem.stalled:
            candidates, iterations = self._continue(call, warm)
            for candidate in candidates:
                if p.verification.passes(call.near, candidate.motion):
                    return self._plan(call, candidate, iterations)
        return self._resample(call, warm, trusted, iterations)

    def _continue(self, call: _Call, warm: Motion) -> tuple[list[EvaluatedCandidate], int]:
        """(the last plan, polished or as it was; quadratic programs solved).

        The list is empty if the plan has become poor.
        """
        n = len(call.near.reference.poses) - 1
        seed = Motion(
            step=warm.step,
            poses=warm.poses[: n + 1],
            inputs=warm.inputs[:n],
            last_input=call.now,
        )
        solution = self._solve(call, seed)
        whole = np.vstack([solution.motion.inputs, warm.inputs[n:]])
        [candidate] = self._evaluate(call, [whole], [_PREVIOUS])
        polished = candidate._replace(motion=solution.motion, value=solution.value)
        before = -np.inf if call.memory is None else call.memory.score
        limit = before + self.parameters.resample_above
        candidates = [polished]
        if candidate.score > limit:  # the cause may be the polishing
            candidates = self._evaluate(call, [warm.inputs], [_PREVIOUS])
        return [each for each in candidates if each.score <= limit], solution.iterations

    def _resample(self, call: _Call, warm: Motion | None, trusted: bool, done: int) -> LocalPlan:
        """The best of the last plan and all samples; ``done``: programs solved before."""
        p = self.parameters
        found = call.sampler.sample(warm)
        sampled = self._candidates(call, found, [_SAMPLED] * len(found))
        old = [] if warm is None else self._evaluate(call, [warm.inputs], [_PREVIOUS])
        polished, iterations = self._polish(call, self._seeds(call, old, sampled))
        raw = [*(old if trusted else []), *sampled]
        costs = [
            *(each.score for each in polished),
            *(each.score + p.polishing_gain for each in raw),
        ]
        every = [*polished, *raw]
        order = [every[k] for k in np.argsort(costs, kind="stable")]
        slower = (self._slower(call, best, share) for best in order[:1] for share in p.speed_shares)
        for candidate in chain(order, slower):
            if p.verification.passes(call.near, candidate.motion):
                return self._plan(call, candidate, done + iterations, resampled=True)
        return self._stop(call, done + iterations)

    def _evaluate(
        self, call: _Call, inputs: list[Floats], names: list[str]
    ) -> list[EvaluatedCandidate]:
        return self._candidates(call, call.sampler.evaluate(np.stack(inputs)), names)

    def _candidates(
        self, call: _Call, found: CandidateTrajectories, names: list[str]
    ) -> list[EvaluatedCandidate]:
        """The first steps of each trajectory as a motion, the rest as its tail."""
        n = len(call.near.reference.poses) - 1
        leaves = class_changes(found.homotopy, call.problem.people, call.memory) > 0
        new = np.array([name != _PREVIOUS for name in names])
        p = self.parameters
        scores = found.score + p.switching_cost * leaves + p.exploration_cost * new
        return [
            EvaluatedCandidate(
                name=name,
                motion=Motion(
                    step=found.step,
                    poses=found.poses[k, : n + 1],
                    inputs=found.inputs[k, :n],
                    last_input=call.now,
                ),
                tail=found.inputs[k, n:],
                score=float(scores[k]),
                own_score=float(found.score[k]),
                homotopy=found.homotopy[k],
            )
            for k, name in enumerate(names)
        ]

    def _seeds(
        self, call: _Call, old: list[EvaluatedCandidate], sampled: list[EvaluatedCandidate]
    ) -> list[EvaluatedCandidate]:
        """Trajectories to polish: the best ones of different homotopy classes."""
        p = self.parameters
        most = 1 if call.problem.late > p.late else p.candidates
        out: list[EvaluatedCandidate] = []
        for candidate in sorted([*old, *sampled], key=lambda each: each.score):
            if len(out) < most and not any(
                np.array_equal(candidate.homotopy, other.homotopy) for other in out
            ):
                out.append(candidate)
        return out

    def _polish(
        self, call: _Call, seeds: list[EvaluatedCandidate]
    ) -> tuple[list[EvaluatedCandidate], int]:
        """(the seeds after the SQP, best first; quadratic programs solved)."""
        solutions = [self._solve(call, seed.motion) for seed in seeds]
        whole = [
            np.vstack([solution.motion.inputs, seed.tail])
            for seed, solution in zip(seeds, solutions, strict=True)
        ]
        evaluated = self._evaluate(call, whole, [seed.name for seed in seeds])
        out = []
        for seed, each, solution in zip(seeds, evaluated, solutions, strict=True):
            worse = each.score > seed.score + self.parameters.polishing_gain
            polished = each._replace(motion=solution.motion, value=solution.value)
            out.append(seed if worse else polished)
        return sorted(out, key=lambda each: each.score), sum(s.iterations for s in solutions)

    def _solve(self, call: _Call, seed: Motion) -> Solution:
        p = self.parameters
        iterations = 1 if call.problem.late > p.late else p.iterations
        near = with_reference_towards(call.near, seed, p.seed_tracking)
        return self.control.solve(near, seed, iterations=iterations)

    def _plan(
        self, call: _Call, chosen: EvaluatedCandidate, iterations: int, *, resampled: bool = False
    ) -> LocalPlan:
        known = None if chosen.value is None else chosen.value.constraints
        value = self.control.value(call.near, chosen.motion, known)
        before = np.inf if resampled or call.memory is None else call.memory.score
        memory = CommittedClass(
            time=call.problem.time,
            side=int(chosen.homotopy[0]),
            id=call.problem.people.id,
            turn=chosen.homotopy[1:],
            tail=chosen.tail,
            last_contact=call.last_contact,
            score=min(chosen.own_score, before),
        )
        return LocalPlan(
            time=call.problem.time,
            step=chosen.motion.step,
            command=call.problem.robot.motion.twist(chosen.motion.inputs[0]),
            poses=chosen.motion.poses,
            inputs=chosen.motion.inputs,
            status=Status.RELAXED if value.slack > _RELAXED else Status.OK,
            costs=MappingProxyType(dict(value.costs)),
            smallest_barrier=value.barrier,
            slack=value.slack,
            iterations=iterations,
            candidate=chosen.name,
            memory=memory,
        )

    def _slower(
        self, call: _Call, candidate: EvaluatedCandidate, share: float
    ) -> EvaluatedCandidate:
        """The trajectory at a share of its speed, as soon as the robot can; same curvature."""
        motion = limited_motion(call.near, share * candidate.motion.inputs, call.now)
        return candidate._replace(
            name=_SLOWER, motion=motion, tail=share * candidate.tail, value=None
        )

    def _stop(self, call: _Call, iterations: int) -> LocalPlan:
        """Braking, with the reason; the commitment of the last plan is kept."""
        steps = len(call.near.reference.poses) - 1
        candidate = EvaluatedCandidate(
            name=_BRAKING,
            motion=braking_motion(call.near, call.now, steps),
            tail=np.zeros((0, len(call.now))),
            score=np.inf,
            own_score=np.inf,
            homotopy=np.zeros(1 + len(call.problem.people), dtype=np.int64),
        )
        plan = self._plan(call, candidate, iterations)
        memory = plan.memory
        if call.memory is not None:
            memory = dataclasses.replace(
                call.memory, tail=candidate.tail, last_contact=call.last_contact
            )
        return dataclasses.replace(
            plan,
            status=Status.STOP,
            reason=Reason.NO_SAFE_PLAN,
            urgent=self.parameters.verification.urgent(call.near, call.now),
            memory=memory,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Call:
    """Everything that the stages of one plan share."""

    problem: LocalProblem
    near: LocalProblem
    """The problem over the planned steps."""
    sampler: PreparedSampler
    """For the whole problem."""
    now: Floats
    """Current input, (m,)."""
    memory: CommittedClass | None
    last_contact: float
    """Time when a walking person last touched the robot, s."""
