"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.candidates import Arcs, Outlook, Ways
from cohelm.control.choice import WayTaken, departures, last_touched, remembered, taken
from cohelm.control.constraints import (
    Bodies,
    GroupSpace,
    InputLimits,
    SocialSpace,
    WallClearance,
)
from cohelm.control.costs import Comfort, InputEffort, Progress, SmoothInput, TrackReference
from cohelm.control.sqp import OptimalControl, Solution, Value
from cohelm.control.usable import usable
from cohelm.control.verification import Verification, brought_to_rest
from cohelm.control.warm_start import followed, last_input, shifted, towards
from cohelm.messages import LocalPlan, Reason, Status

_LAST, _SAMPLED, _SLOWER, _REST = "last", "sampled", "slower", "rest"
"""Where ways come from, ``LocalPlan.candidate``."""
_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""


class SsMpcDcbf:
    """The paper's local planner: the reference tracked, people and walls as barriers.

    A few ways round, the last plan among them, are polished by the SQP. The cheapest verified one
    is taken, those that were not polished included, where leaving the last way costs (see
    ``choice``); else the best one at a share of its speed; else the robot brakes, with a reason.
    With ``candidates = 1`` the last plan, polished, goes on without a look at others, as long as it
    is verified and has not become poor.
    """

    class Parameters(Model):
        """Steps, budget, terms and constraints; the paper gives no figures, these are assumed."""

        steps: int = Field(25, ge=3, le=100)
        """N, the steps that are polished and planned."""
        step: float = Field(0.16, gt=0.0, le=1.0)
        """Δt, s; longer than a tick, which is why the last plan is shifted by interpolation."""
        candidates: int = Field(2, ge=1, le=8)
        """Ways that are polished. With one it is the last plan, as in the paper: ways are sampled
        only where there is none, it is not verified, the ride is stalled, or it became ``poor``."""
        poor: float = Field(1.0, ge=0.0, le=100.0)
        """With one candidate: by so much a plan may be worse than it was before the planner looks
        round, s."""
        iterations: int = Field(2, ge=1, le=50)
        """Quadratic programs for each of them: the budget, the same on every machine."""
        loyalty: float = Field(1.5, ge=0.0, le=100.0)
        """What it costs to pass anybody, or the path, on another side than the last plan, s."""
        novelty: float = Field(0.2, ge=0.0, le=100.0)
        """What a sampled way has to be better by than the last plan that it replaces, s."""
        spoilt: float = Field(1.0, ge=0.0, le=100.0)
        """What polishing is worth: a way that it makes worse by more than this is taken as it was,
        and a way that was not polished has to be better by this, s."""
        follow: float = Field(0.5, ge=0.0, le=1.0)
        """Share of the way itself in the reference that its polishing tracks."""
        late: float = Field(0.05, gt=0.0, le=1.0)
        """Lateness from which on one way is polished, once, s: a tick."""
        slower: tuple[float, ...] = (0.6, 0.3)
        """Shares of its speed at which the best way is tried where none is verified as it is."""
        patience: float = Field(1.0, ge=0.0, le=10.0)
        """How long the robot stands after somebody who walks has touched it, s."""
        arcs: Arcs.Parameters = Arcs.Parameters(count=160, pushes=40, rounds=1)
        verification: Verification = Verification()
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        comfort: Comfort.Parameters = Comfort.Parameters()
        progress: Progress.Parameters = Progress.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallClearance.Parameters = WallClearance.Parameters()
        bodies: Bodies.Parameters = Bodies.Parameters(at_least=1.0)
        social_space: SocialSpace.Parameters = SocialSpace.Parameters()
        group_space: GroupSpace.Parameters = GroupSpace.Parameters()

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = max(p.steps, round(p.arcs.horizon / p.step)), p.step
        self.arcs = Arcs(p.arcs)
        self.control = OptimalControl(
            costs=(
                TrackReference(p.track_reference),
                InputEffort(p.input_effort),
                SmoothInput(p.smooth_input),
                Comfort(p.comfort),
                Progress(p.progress),
            ),
            constraints=(
                InputLimits(p.input_limits),
                WallClearance(p.wall_clearance),
                Bodies(p.bodies),
                SocialSpace(p.social_space),
                GroupSpace(p.group_space),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        p = self.parameters
        problem = usable(problem)
        memory = remembered(previous, problem.time)
        now = last_input(problem, previous)
        asked = _Asked(
            problem=problem,
            near=problem.within(p.steps),
            outlook=self.arcs.look(problem, now),
            now=now,
            memory=memory,
            touched=last_touched(problem, memory),
        )
        if problem.time - asked.touched < p.patience:
            return self._stop(asked, 0)
        beyond = None if memory is None else memory.beyond
        warm = shifted(asked.near, previous, asked.now, beyond=beyond)
        trusted = previous is not None and previous.status is not Status.STOP
        iterations = 0
        if p.candidates == 1 and warm is not None and trusted and not problem.stalled:
            ways, iterations = self._went_on(asked, warm)
            for way in ways:
                if p.verification.passes(asked.near, way.motion):
                    return self._plan(asked, way, iterations)
        return self._looked_round(asked, warm, trusted, iterations)

    def _went_on(self, asked: _Asked, warm: Motion) -> tuple[list[_Way], int]:
        """(The last plan, polished, or as it was; quadratic programs solved).

        No way at all where it has become poor.
        """
        n = len(asked.near.reference.poses) - 1
        seed = Motion(
            step=warm.step,
            poses=warm.poses[: n + 1],
            inputs=warm.inputs[:n],
            last_input=asked.now,
        )
        solution = self._solved(asked, seed)
        whole = np.vstack([solution.motion.inputs, warm.inputs[n:]])
        [way] = self._judged(asked, [whole], [_LAST])
        ways = [way._replace(motion=solution.motion, found=solution.value)]
        before = -np.inf if asked.memory is None else asked.memory.score
        if way.score > before + self.parameters.poor:  # was it the polishing?
            ways = self._judged(asked, [warm.inputs], [_LAST])
        return [way for way in ways if way.score <= before + self.parameters.poor], (
            solution.iterations
        )

    def _looked_round(
        self, asked: _Asked, warm: Motion | None, trusted: bool, done: int
    ) -> LocalPlan:
        """The plan among the last and all sampled ways; ``done`` programs were solved before."""
        p = self.parameters
        sampled = self._sampled(asked, warm)
        old = [] if warm is None else self._judged(asked, [warm.inputs], [_LAST])
        polished, iterations = self._polished(asked, self._seeds(asked, old, sampled))
        raw = [*(old if trusted else []), *sampled]
        costs = [*(way.score for way in polished), *(way.score + p.spoilt for way in raw)]
        every = [*polished, *raw]
        order = [every[k] for k in np.argsort(costs, kind="stable")]
        slower = (self._slower(asked, way, share) for way in order[:1] for share in p.slower)
        for way in chain(order, slower):
            if p.verification.passes(asked.near, way.motion):
                return self._plan(asked, way, done + iterations, looked_round=True)
        return self._stop(asked, done + iterations)

    def _sampled(self, asked: _Asked, warm: Motion | None) -> list[_Way]:
        """Sampled ways, the best ones first."""
        found = asked.outlook.ways(warm)
        return self._listed(asked, found, [_SAMPLED] * len(found))

    def _judged(self, asked: _Asked, inputs: list[Floats], names: list[str]) -> list[_Way]:
        return self._listed(asked, asked.outlook.score(np.stack(inputs)), names)

    def _listed(self, asked: _Asked, found: Ways, names: list[str]) -> list[_Way]:
        """The first steps of each way as a motion, the rest as what lies beyond."""
        n = len(asked.near.reference.poses) - 1
        leaves = departures(found.signature, asked.problem.people, asked.memory) > 0
        new = np.array([name != _LAST for name in names])
        scores = found.score + self.parameters.loyalty * leaves + self.parameters.novelty * new
        return [
            _Way(
                name=name,
                motion=Motion(
                    step=found.step,
                    poses=found.poses[k, : n + 1],
                    inputs=found.inputs[k, :n],
                    last_input=asked.now,
                ),
                beyond=found.inputs[k, n:],
                score=float(scores[k]),
                alone=float(found.score[k]),
                signature=found.signature[k],
            )
            for k, name in enumerate(names)
        ]

    def _seeds(self, asked: _Asked, old: list[_Way], sampled: list[_Way]) -> list[_Way]:
        """The ways that are polished: the last plan, and the best that pass otherwise."""
        p = self.parameters
        most = 1 if asked.problem.late > p.late else p.candidates
        out: list[_Way] = []
        for way in sorted([*old, *sampled], key=lambda way: way.score):
            if len(out) < most and not any(
                np.array_equal(way.signature, other.signature) for other in out
            ):
                out.append(way)
        return out

    def _polished(self, asked: _Asked, seeds: list[_Way]) -> tuple[list[_Way], int]:
        """(The ways after the SQP, the best ones first; quadratic programs solved)."""
        solutions = [self._solved(asked, seed.motion) for seed in seeds]
        whole = [
            np.vstack([solution.motion.inputs, seed.beyond])
            for seed, solution in zip(seeds, solutions, strict=True)
        ]
        judged = self._judged(asked, whole, [seed.name for seed in seeds])
        ways = [
            way._replace(motion=solution.motion, found=solution.value)
            for way, solution in zip(judged, solutions, strict=True)
        ]
        kept = [
            seed if way.score > seed.score + self.parameters.spoilt else way
            for seed, way in zip(seeds, ways, strict=True)
        ]
        return sorted(kept, key=lambda way: way.score), sum(s.iterations for s in solutions)

    def _solved(self, asked: _Asked, seed: Motion) -> Solution:
        p = self.parameters
        iterations = 1 if asked.problem.late > p.late else p.iterations
        near = towards(asked.near, seed, p.follow)
        return self.control.solve(near, seed, iterations=iterations)

    def _plan(
        self, asked: _Asked, way: _Way, iterations: int, *, looked_round: bool = False
    ) -> LocalPlan:
        measures = None if way.found is None else way.found.measures
        value = self.control.value(asked.near, way.motion, measures)
        before = np.inf if looked_round or asked.memory is None else asked.memory.score
        memory = taken(
            asked.problem.time,
            way.signature,
            asked.problem.people,
            beyond=way.beyond,
            touched=asked.touched,
            score=min(way.alone, before),
        )
        return LocalPlan(
            time=asked.problem.time,
            step=way.motion.step,
            command=asked.problem.robot.motion.twist(way.motion.inputs[0]),
            poses=way.motion.poses,
            inputs=way.motion.inputs,
            status=Status.RELAXED if value.slack > _RELAXED else Status.OK,
            costs=MappingProxyType(dict(value.costs)),
            smallest_barrier=value.barrier,
            slack=value.slack,
            iterations=iterations,
            candidate=way.name,
            memory=memory,
        )

    def _slower(self, asked: _Asked, way: _Way, share: float) -> _Way:
        """The same way at a share of its speed, as soon as the robot can; its arcs are kept."""
        motion = followed(asked.near, share * way.motion.inputs, asked.now)
        return way._replace(name=_SLOWER, motion=motion, beyond=share * way.beyond, found=None)

    def _stop(self, asked: _Asked, iterations: int) -> LocalPlan:
        """Braking, with the reason; how the last plan passed everybody is still remembered."""
        steps = len(asked.near.reference.poses) - 1
        motion = brought_to_rest(asked.near, asked.now, steps)
        nobody = np.zeros(1 + len(asked.problem.people), dtype=np.int64)
        way = _Way(
            name=_REST,
            motion=motion,
            beyond=np.zeros((0, len(asked.now))),
            score=np.inf,
            alone=np.inf,
            signature=nobody,
        )
        plan = self._plan(asked, way, iterations)
        memory = plan.memory
        if asked.memory is not None:
            memory = dataclasses.replace(asked.memory, beyond=way.beyond, touched=asked.touched)
        return dataclasses.replace(
            plan,
            status=Status.STOP,
            reason=Reason.NO_SAFE_PLAN,
            urgent=self.parameters.verification.urgent(asked.near, asked.now),
            memory=memory,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Asked:
    """What a plan is made for."""

    problem: LocalProblem
    near: LocalProblem
    """The same over the steps that are planned."""
    outlook: Outlook
    """What can be said of ways through all of it."""
    now: Floats
    """What the wheels do, (m,)."""
    memory: WayTaken | None
    touched: float
    """When somebody who walks was last seen to touch the robot, s."""


class _Way(NamedTuple):
    """A way that may be taken."""

    name: str
    motion: Motion
    beyond: Floats
    """(L, m) inputs with which it goes on."""
    score: float
    """s, what leaving the last way costs included."""
    alone: float
    """The same without that."""
    signature: Integers
    found: Value | None = None
    """What the SQP found at the motion, where it ended there; its costs are those of polishing."""
