"""Candidate trajectories of one planning cycle with their selection cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.planner_memory import PlannerMemory, class_changes
from cohelm.control.sampling import CandidateTrajectories, PreparedSampler
from cohelm.control.sqp import Solution, TrajectoryEvaluation
from cohelm.control.trajectories import braking_trajectory, limited_trajectory

PREVIOUS, SAMPLED, SLOWER, BRAKING = "previous", "sampled", "slower", "braking"
"""Origins of a candidate, ``LocalPlan.candidate``."""


class EvaluatedCandidate(NamedTuple):
    """A trajectory that may be used."""

    origin: str
    """``PREVIOUS``, ``SAMPLED``, ``SLOWER`` or ``BRAKING``."""
    trajectory: Trajectory
    """The N steps of the SQP and of the plan."""
    tail: Floats
    """(L, m) inputs that continue it to the sampler's horizon."""
    selection_cost: float
    """Trajectory cost plus switching and exploration costs, s; the cheapest safe one is used."""
    trajectory_cost: float
    """The sampler's cost of the trajectory with its tail, s."""
    passing_sides: Integers
    """(1 + n,) row of ``CandidateTrajectories.passing_sides``."""
    evaluation: TrajectoryEvaluation | None = None
    """The SQP's costs and constraint values at the trajectory, with the reference moved towards its
    seed; None if it was not refined."""

    def with_solution(self, solution: Solution) -> EvaluatedCandidate:
        """The candidate with the SQP's own trajectory and evaluation."""
        return self._replace(trajectory=solution.trajectory, evaluation=solution.evaluation)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanningCycle:
    """Everything that the stages of one plan share."""

    problem: LocalProblem
    mpc_problem: LocalProblem
    """The problem over the N steps of the SQP and of the plan."""
    sampler: PreparedSampler
    """For the whole problem."""
    current_input: Floats
    """u_{−1}, (m,)."""
    memory: PlannerMemory | None
    last_contact: float
    """Time when a walking person last touched the robot, s."""
    switching_cost: float
    """Cost of leaving the committed homotopy class, s."""
    exploration_cost: float
    """Cost of replacing the last plan by a sampled trajectory, s."""

    @property
    def steps(self) -> int:
        """N."""
        return len(self.mpc_problem.reference.poses) - 1

    def sample(self, warm: Trajectory | None) -> list[EvaluatedCandidate]:
        """New candidates, cheapest trajectory first; ``warm``: the last plan, perturbed as well."""
        sampled = self.sampler.sample(warm)
        return self._candidates(sampled, [SAMPLED] * len(sampled))

    def evaluate(self, full_inputs: list[Floats], origins: list[str]) -> list[EvaluatedCandidate]:
        """Candidates of given inputs (L, m) each, over the sampler's horizon, in the same order."""
        return self._candidates(self.sampler.evaluate(np.stack(full_inputs)), origins)

    def slowed(self, candidate: EvaluatedCandidate, share: float) -> EvaluatedCandidate:
        """The candidate at a share of its speed, as soon as the robot can; same curvature."""
        inputs = share * candidate.trajectory.inputs
        return candidate._replace(
            origin=SLOWER,
            trajectory=limited_trajectory(self.mpc_problem, inputs, self.current_input),
            tail=share * candidate.tail,
            evaluation=None,
        )

    def braking(self) -> EvaluatedCandidate:
        """Comfort braking, which passes nobody on a side."""
        return EvaluatedCandidate(
            origin=BRAKING,
            trajectory=braking_trajectory(self.mpc_problem, self.current_input, self.steps),
            tail=np.zeros((0, len(self.current_input))),
            selection_cost=np.inf,
            trajectory_cost=np.inf,
            passing_sides=np.zeros(1 + len(self.problem.people), dtype=np.int64),
        )

    def _candidates(
        self, trajectories: CandidateTrajectories, origins: list[str]
    ) -> list[EvaluatedCandidate]:
        """Split each trajectory into its first N steps and the tail; add the selection costs."""
        n = self.steps
        sides, cost = trajectories.passing_sides, trajectories.cost
        switches = class_changes(sides, self.problem.people, self.memory) > 0
        explores = np.array([origin != PREVIOUS for origin in origins])
        selection = cost + self.switching_cost * switches + self.exploration_cost * explores
        return [
            EvaluatedCandidate(
                origin=origin,
                trajectory=Trajectory(
                    step=trajectories.step,
                    poses=trajectories.poses[k, : n + 1],
                    inputs=trajectories.inputs[k, :n],
                    current_input=self.current_input,
                ),
                tail=trajectories.inputs[k, n:],
                selection_cost=float(selection[k]),
                trajectory_cost=float(cost[k]),
                passing_sides=sides[k],
            )
            for k, origin in enumerate(origins)
        ]


def cheapest_of_different_classes(
    candidates: list[EvaluatedCandidate], count: int
) -> list[EvaluatedCandidate]:
    """At most ``count`` candidates, cheapest first, no two of which pass on the same sides."""
    out: list[EvaluatedCandidate] = []
    for candidate in sorted(candidates, key=lambda each: each.selection_cost):
        if len(out) < count and not any(
            np.array_equal(candidate.passing_sides, other.passing_sides) for other in out
        ):
            out.append(candidate)
    return out
