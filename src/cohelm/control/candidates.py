"""Candidate trajectories of one planning cycle: every one is judged by the same objective.

The score of a candidate is the objective plus the terms of the choice: the side on which the rider
wants to pass, leaving the committed homotopy class, replacing the last plan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.optimal_control import PreparedControl
from cohelm.control.planner_memory import PlannerMemory, class_changes
from cohelm.control.sampling import CandidateTrajectories, Sampling, evaluate, sample
from cohelm.control.trajectories import braking_trajectory
from cohelm.control.verification import Verifier
from cohelm.robots.braking import STANDING

PREVIOUS, SAMPLED, STOPPING, SLOWER, BRAKING = (
    "previous", "sampled", "stopping", "slower", "braking",
)  # fmt: skip
"""Origins of a candidate, ``LocalPlan.candidate``."""
_GENTLE = (0.35, 0.6, 1.0)
"""Shares of the comfort deceleration with which a stop is asked for; the limits of a plan hold, so
that a unicycle brakes with 0.75 of it at most."""
_SIDES = {"right": 1, "left": -1, "none": 0}
"""Turn of the bearing to a person passed on that side."""
_SEED_WINDOW = 1.5
"""A seed that costs more than the best one by this is not improved, s: it rarely wins."""
CHOICES = ("passing_side", "switching", "replacing")
"""Names of the terms of the choice."""


class Choice(Model):
    """Terms of the choice between trajectories; tuned on rides."""

    passing_side: float = Field(0.4, ge=0.0, le=100.0)
    """Cost of passing a person on the side that the rider does not prefer, s."""
    switching: float = Field(1.5, ge=0.0, le=100.0)
    """Cost of leaving the committed homotopy class, s."""
    replacing: float = Field(0.2, ge=0.0, le=100.0)
    """Cost of replacing the last plan by another trajectory, s."""


class Candidate(NamedTuple):
    """A trajectory that may be used."""

    origin: str
    """``PREVIOUS``, ``SAMPLED``, ``STOPPING``, ``SLOWER`` or ``BRAKING``."""
    inputs: Floats
    """(L, m) over the horizon of the objective."""
    poses: Floats
    """(L+1, 3)."""
    score: float
    """Objective and terms of the choice, s; the cheapest safe one is used."""
    cost: float
    """The objective alone, s."""
    by_term: Floats
    """(T + 3,) summands of the score."""
    slack: float
    """Largest violation of a barrier, m."""
    passing_sides: Integers
    """(1 + n,) row of ``CandidateTrajectories.passing_sides``."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanningCycle:
    """Everything that the stages of one plan share."""

    problem: LocalProblem
    mpc_problem: LocalProblem
    """The problem over the N steps of the plan."""
    prepared: PreparedControl
    """The problem as tables, over the horizon of the objective."""
    current_input: Floats
    """u_{−1}, (m,)."""
    memory: PlannerMemory | None
    person_speeds: Floats
    """(n,) of people lately, m/s."""
    person_paces: Floats
    """(n,) paces, see ``planner_memory.recent_paces``, m/s."""
    person_courses: Floats
    """(n,) times for which people have been on a course into the robot, s."""
    verifier: Verifier
    choice: Choice

    @property
    def steps(self) -> int:
        """N."""
        return self.prepared.scene.planned

    @property
    def stands(self) -> bool:
        """The robot stands."""
        return _is_standing(self.current_input)

    @property
    def stands_since(self) -> float:
        """Time when the robot came to a stand, s; +inf: it moves, or has not moved before."""
        if not self.stands or self.memory is None:
            return np.inf
        moved = not _is_standing(self.memory.current_input)
        return self.problem.time if moved else self.memory.stands_since

    def trajectory(self, candidate: Candidate) -> Trajectory:
        """The first N steps of a candidate."""
        n = self.steps
        return Trajectory(
            step=self.prepared.scene.step,
            poses=candidate.poses[: n + 1],
            inputs=candidate.inputs[:n],
            current_input=self.current_input,
        )

    def accepts(self, candidate: Candidate) -> bool:
        """Check a candidate, see ``verification``."""
        return self.verifier.accepts(self.trajectory(candidate))

    def sample(self, budget: Sampling, warm: Trajectory | None) -> list[Candidate]:
        """The last plan ``warm``, if there is one, then new candidates, cheapest first."""
        found = sample(self.prepared, budget, warm)
        last = [] if warm is None else [PREVIOUS]
        return self._candidates(found, last + [SAMPLED] * (len(found) - len(last)))

    def evaluate(self, inputs: list[Floats], origins: list[str]) -> list[Candidate]:
        """Candidates of given inputs (K, m) each, in the same order."""
        return self._candidates(evaluate(self.prepared, np.stack(inputs)), origins)

    def stops(self, candidate: Candidate | None) -> list[Candidate]:
        """Gentle stops on the way of a candidate, or on the present arc without one."""
        steps, step = self.prepared.scene.steps, self.prepared.scene.step
        _, _, _, fall = self.problem.robot.input_bounds
        n_linear = self.problem.robot.motion_model.translating
        begin = self.current_input if candidate is None else candidate.inputs[0]
        speed = float(np.linalg.norm(begin[:n_linear]))
        if speed <= 0.0:
            return []
        way = np.tile(begin, (steps, 1)) if candidate is None else candidate.inputs
        times = (np.arange(steps) + 0.5) * step
        inputs = [
            np.clip(1.0 - share * fall[0] * times / speed, 0.0, 1.0)[:, None] * way
            for share in _GENTLE
        ]
        return self.evaluate(inputs, [STOPPING] * len(inputs))

    def slowed(self, candidate: Candidate, share: float) -> Candidate:
        """The candidate at a share of its speed, as soon as the robot can; same curvature."""
        [slower] = self.evaluate([share * candidate.inputs], [SLOWER])
        return slower

    def braking(self, share: float = 1.0) -> Candidate:
        """Braking at a share of the comfort deceleration, at once and without a limit of jerk."""
        steps = self.prepared.scene.steps
        braking = braking_trajectory(self.problem, self.current_input, steps, share=share)
        [candidate] = self.evaluate([braking.inputs], [BRAKING])
        # the candidate is limited in jerk, and braking is not
        braked = self.prepared.evaluate(braking.inputs)
        by_term = np.concatenate([list(braked.costs.values()), candidate.by_term[-len(CHOICES) :]])
        return candidate._replace(
            inputs=braking.inputs,
            poses=braking.poses,
            score=float(by_term.sum()),
            cost=braked.cost,
            by_term=by_term,
            slack=braked.slack,
        )

    def _candidates(
        self, trajectories: CandidateTrajectories, origins: list[str]
    ) -> list[Candidate]:
        """Add the terms of the choice."""
        choice, sides = self.choice, trajectories.passing_sides
        preferred = _SIDES[self.problem.profile.passing_side]
        wrong = (sides[:, 1:] == -preferred).sum(axis=1) if preferred else np.zeros(len(sides))
        switches = class_changes(sides, self.problem.people, self.memory) > 0
        replaces = np.array([origin != PREVIOUS for origin in origins])
        added = np.empty((len(sides), 3))
        added[:, 0] = choice.passing_side * wrong
        added[:, 1] = choice.switching * switches
        added[:, 2] = choice.replacing * replaces
        by_term = np.concatenate([trajectories.by_term, added], axis=1)
        costs, slacks = trajectories.cost.tolist(), trajectories.slack.tolist()
        scores = (trajectories.cost + added.sum(axis=1)).tolist()
        return [
            Candidate(
                origin=origin,
                inputs=trajectories.inputs[k],
                poses=trajectories.poses[k],
                score=scores[k],
                cost=costs[k],
                by_term=by_term[k],
                slack=slacks[k],
                passing_sides=sides[k],
            )
            for k, origin in enumerate(origins)
        ]


def _is_standing(inputs: Floats) -> bool:
    return math.sqrt(inputs @ inputs) < STANDING


def cheapest_of_different_classes(candidates: list[Candidate], count: int) -> list[Candidate]:
    """At most ``count`` candidates, cheapest first, no two of which pass on the same sides.

    Those that cost much more than the first are left out.
    """
    out: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda each: each.score):
        if len(out) == count or (out and candidate.score > out[0].score + _SEED_WINDOW):
            break
        if not any(np.array_equal(candidate.passing_sides, other.passing_sides) for other in out):
            out.append(candidate)
    return out
