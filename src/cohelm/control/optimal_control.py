"""An optimal-control problem over the one objective: evaluated and solved by compiled code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.control import sqp
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.constraint_rows import smallest_barrier
from cohelm.control.daqp_call import daqp_addresses
from cohelm.control.objective import trajectory_cost
from cohelm.control.objective_tables import TERMS, Objective, Workspace, workspace
from cohelm.control.scene import Scene, SceneSettings, coarser, make_scene
from cohelm.control.solver_tables import SolverWorkspace, solver_workspace
from cohelm.control.stack import Terms
from cohelm.control.terms import ExtraTerm
from cohelm.errors import SolverFailed
from cohelm.robots.clearance import Clearance

RELAXED_SLACK = 0.01
"""A plan with more slack than this is reported as relaxed, m."""
_ROWS = 1024
"""Rows of a workspace at first; it grows where a crowd needs more."""


class TrajectoryEvaluation(NamedTuple):
    """Cost of a trajectory and its distance from the barriers."""

    cost: float
    """Value of the objective, s."""
    costs: Mapping[str, float]
    """Its summands by name."""
    slack: float
    """Largest violation of a barrier, m."""
    barrier: float
    """Smallest h of any barrier, m; 1 at most."""


class Solution(NamedTuple):
    """Result of the SQP."""

    trajectory: Trajectory
    evaluation: TrajectoryEvaluation
    iterations: int
    """Quadratic programs solved."""


class OptimalControl:
    """An optimal-control problem, solved for one ``LocalProblem`` after another.

    It keeps nothing but workspaces.

    Args:
        terms: terms and barriers.
        clearance: clearance from people.
        extra_terms: terms of one's own.
        tick: time between two commands, s: the first change of input must fit into it.
        norm: of distances to bodies.
    """

    def __init__(
        self,
        terms: Terms,
        clearance: Clearance,
        *,
        extra_terms: Sequence[ExtraTerm] = (),
        tick: float = 0.05,
        norm: Literal[1, 2, "inf"] = 2,
    ) -> None:
        self.terms, self.clearance = terms, clearance
        self.extra_terms = tuple(extra_terms)
        self.tick, self.norm = tick, norm
        self.names = (*TERMS, *(term.name for term in self.extra_terms))
        self._workspaces: dict[tuple[int, ...], SolverWorkspace] = {}

    def prepare(
        self,
        problem: LocalProblem,
        current_input: Floats,
        *,
        planned: int | None = None,
        steps: int | None = None,
        wall_margin: float = 0.0,
        acceleration: float = 0.0,
    ) -> PreparedControl:
        """The tables of one problem.

        Args:
            problem: the problem.
            current_input: u_{−1}, (m,).
            planned: N, steps that the SQP changes; None: all of the reference.
            steps: L, horizon of the objective; None: N.
            wall_margin: gap to a wall that counts as contact, m.
            acceleration: present linear acceleration, m/s².
        """
        planned = planned or len(problem.reference.speeds) - 1
        settings = SceneSettings(
            steps=steps or planned,
            planned=planned,
            clearance=self.clearance,
            wall_margin=wall_margin,
            tick=self.tick,
            acceleration=acceleration,
        )
        scene = make_scene(problem, current_input, settings)
        objective = self.terms.objective(scene, problem, self.extra_terms, norm=self.norm)
        return PreparedControl(
            control=self, problem=problem, scene=scene, objective=objective,
            work=workspace(scene, objective),
        )  # fmt: skip

    def solve(
        self,
        problem: LocalProblem,
        seed: Trajectory,
        *,
        iterations: int,
        tolerance: float = 1e-2,
    ) -> Solution:
        """Solve at most ``iterations`` quadratic programs from ``seed``, until Δu < tolerance.

        Args:
            problem: the problem; the horizon is that of the seed.
            seed: start of the iteration.
            iterations: the budget.
            tolerance: on every input, m/s and rad/s.

        Raises:
            SolverFailed: if a quadratic program has no solution.
        """
        prepared = self.prepare(problem, seed.current_input, planned=len(seed.inputs))
        inputs, done = prepared.solve(seed.inputs, iterations=iterations, tolerance=tolerance)
        return Solution(prepared.trajectory(inputs), prepared.evaluate(inputs), done)

    def evaluate(self, problem: LocalProblem, trajectory: Trajectory) -> TrajectoryEvaluation:
        """Evaluate the objective at a trajectory, over its own steps."""
        prepared = self.prepare(problem, trajectory.current_input, planned=len(trajectory.inputs))
        return prepared.evaluate(trajectory.inputs)

    def space(self, scene: Scene, objective: Objective, rows: int = _ROWS) -> SolverWorkspace:
        """A workspace for the size of a problem, made once and used again."""
        key = (
            scene.steps, scene.planned, len(scene.robot.current_input), scene.people.num_people,
            len(scene.people.weight), len(scene.robot.discs), len(objective.extra.address),
        )  # fmt: skip
        known = self._workspaces.get(key)
        if known is None or len(known.rows.margin) < rows:
            known = solver_workspace(scene, objective, rows)
            self._workspaces[key] = known
        return known


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedControl:
    """A problem as tables; it lives for one plan."""

    control: OptimalControl
    problem: LocalProblem
    scene: Scene
    objective: Objective
    work: Workspace

    def coarser(self, stride: int) -> tuple[Scene, Objective]:
        """(scene, objective) with ``stride`` steps in one."""
        if stride == 1:
            return self.scene, self.objective
        scene = coarser(self.scene, stride)
        return scene, self.control.terms.coarser(self.objective, scene, stride)

    def solve(
        self, inputs: Floats, *, iterations: int, tolerance: float = 1e-2
    ) -> tuple[Floats, int]:
        """(inputs (L, m) improved by the SQP, quadratic programs solved).

        Raises:
            SolverFailed: if a quadratic program has no solution.
        """
        out, rows = np.array(inputs, dtype=float), _ROWS
        while True:
            space = self.control.space(self.scene, self.objective, rows)
            flag, solved, _ = sqp.solve(
                self.scene, self.objective, daqp_addresses(), space, out, iterations, tolerance
            )
            if flag != sqp.FULL:
                break
            rows = 4 * len(space.rows.margin)
        if flag < 1:
            raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
        return out, solved

    def trajectory(self, inputs: Floats) -> Trajectory:
        """The trajectory of inputs (K, m)."""
        step = self.scene.step
        model = self.problem.robot.motion_model
        return Trajectory(
            step=step,
            poses=model.rollout(self.problem.pose, inputs, step),
            inputs=inputs,
            current_input=self.scene.robot.current_input,
        )

    def evaluate(self, inputs: Floats) -> TrajectoryEvaluation:
        """Evaluate the objective at inputs (L, m)."""
        poses = np.empty((len(inputs) + 1, 3))
        inputs = np.ascontiguousarray(inputs, dtype=float)
        cost = trajectory_cost(self.scene, self.objective, inputs, poses, self.work)
        costs = dict(zip(self.control.names, self.work.by_term.tolist(), strict=True))
        return TrajectoryEvaluation(cost, costs, self.slack(), self.barrier(inputs))

    def slack(self) -> float:
        """Largest violation of a barrier in the last evaluation, m."""
        return max(float(self.work.violation.max(initial=0.0)), float(self.work.wall_violation[0]))

    def barrier(self, inputs: Floats) -> float:
        """Smallest h of any barrier along inputs, m; 1 at most."""
        space = self.control.space(self.scene, self.objective)
        return float(smallest_barrier(self.scene, self.objective, space, inputs))
