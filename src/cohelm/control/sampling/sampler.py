"""Sampler of candidate trajectories: three-segment arcs over a longer horizon than the SQP's.

A gradient method stays in one homotopy class. Some hundred arcs explore the others: a seeded table,
of which many arcs return to the path, then perturbations of the best ones and of the last plan. One
trajectory cost ranks sampled, refined and previous trajectories: the time lost against the
reference, in seconds, and in the same unit the effects on people, rider and walls.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.sampling.arc_table import arc_table, perturbations
from cohelm.control.sampling.candidates import CandidateTrajectories, passing_sides
from cohelm.control.sampling.rollout import RolloutWeights
from cohelm.control.sampling.scene import RolloutScene, coarser, rollout_scene
from cohelm.control.sampling.search import SearchBudget, evaluate_inputs, search_arcs
from cohelm.control.terms.constraints.prediction_selection import oncoming_share

_EXAMINED = 24
"""Arcs among which different homotopy classes are selected."""
_SIDES = {"right": 1, "left": -1, "none": 0}
"""Turn of the bearing to a person passed on that side."""


class TrajectorySampler:
    """Sampled candidate trajectories, and the cost of any trajectory."""

    class Parameters(Model):
        """Sampling, margins and weights, assumed unless a source is named; tuned on rides."""

        horizon: float = Field(6.0, gt=0.0, le=20.0)
        """Horizon of the arcs, s; never less than the problem's own."""
        stride: int = Field(2, ge=1, le=10)
        """Steps of the problem per step of the search; its results are evaluated in all steps."""
        count: int = Field(400, ge=50, le=20_000)
        """Arcs of the table."""
        perturbations: int = Field(48, ge=0, le=1000)
        """Perturbations of each of the best arcs, per round."""
        rounds: int = Field(2, ge=0, le=10)
        """Rounds of perturbation."""
        elite: int = Field(4, ge=1, le=50)
        """Arcs that are perturbed in each round."""
        max_classes: int = Field(4, ge=1, le=_EXAMINED)
        """Maximum number of different homotopy classes in the result."""
        cost_window: float = Field(2.5, gt=0.0, le=100.0)
        """Candidates that cost more than the best one by this are dropped, s."""
        final_delay: float = Field(1.0, ge=0.0)
        """Cost of a second lost at the end of the horizon."""
        mean_delay: float = Field(1.0, ge=0.0)
        """Cost of a second lost on average over the horizon: sooner is better."""
        path_distance: float = Field(0.08, ge=0.0)
        """Cost of the squared distance from the path, 1/m²: small, a detour is no fault."""
        final_heading: float = Field(1.0, ge=0.0)
        """Cost of 1 − cos of the final angle between the heading and the path ahead, s."""
        turning: float = Field(0.15, ge=0.0)
        """Cost of ω², s²."""
        acceleration: float = Field(0.016, ge=0.0)
        """Cost of squared accelerations, s⁴/m² and s⁴/rad²."""
        contact: float = Field(60.0, ge=0.0)
        """Cost of the squared intrusion into the margin of a person, 1/m²."""
        standing_share: float = Field(0.4, ge=0.0, le=1.0)
        """Share of the costs of people while the robot stands: people may walk into it anyway."""
        decay_time: float = Field(4.0, gt=0.0)
        """Time constant with which the weight of predictions decays, s."""
        margin: float = Field(0.12, ge=0.0)
        """Margin of a person now, m."""
        standing_margin: float | None = Field(None, ge=0.0)
        """Margin of a standing person, m, at most ``margin``; None: the same."""
        growth: float = Field(0.08, ge=0.0)
        """Growth of the margin of walking people with prediction time, m/s."""
        oncoming_margin: float = Field(0.0, ge=0.0)
        """Additional growth for oncoming people, m/s; see ``oncoming_share``."""
        deviations: float = Field(0.0, ge=0.0)
        """Standard deviations of the predicted position that are added to the margin."""
        max_margin: float = Field(0.4, ge=0.0)
        """Upper bound of the margin, m."""
        stalled_margin: float = Field(0.06, ge=0.0)
        """Margin while the ride is stalled, m; it does not grow then."""
        personal_space: float = Field(0.8, ge=0.0)
        """Cost of the squared share of intrusion into a personal space."""
        group_space: float = Field(25.0, ge=0.0)
        """Cost of the squared depth in a group's space, 1/m²: high enough for a detour where there
        is one, and low enough for a robot inside a group to leave it."""
        wall: float = Field(0.5, ge=0.0)
        """Cost of the squared missing share of the clearance to walls."""
        wall_clearance: float = Field(0.1, ge=0.0)
        """Desired gap to walls beyond the rider's clearance, m."""
        wall_margin: float = Field(0.02, ge=0.0)
        """Gap to a wall that counts as contact, m."""
        stalled_wall_margin: float = Field(0.012, ge=0.0)
        """Gap to a wall that counts as contact while the ride is stalled, m."""
        passing_side: float = Field(0.4, ge=0.0)
        """Cost of passing a person on the side that the rider does not prefer, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def prepare(self, problem: LocalProblem, current_input: Floats) -> PreparedSampler:
        """The sampler for one problem; everything that trajectories share is computed once.

        Args:
            problem: the problem.
            current_input: u_{−1}, (m,).
        """
        p = self.parameters
        steps = max(round(p.horizon / problem.reference.step), len(problem.reference.speeds) - 1)
        margin = p.stalled_wall_margin if problem.stalled else p.wall_margin
        scene = rollout_scene(problem, current_input, p.stride * -(-steps // p.stride), margin)
        return PreparedSampler(
            parameters=p,
            problem=problem,
            scene=scene,
            weights=_weights(p, problem, scene),
            likeliest=_likeliest(problem, scene),
        )

    def sample(
        self, problem: LocalProblem, current_input: Floats, warm: Trajectory | None = None
    ) -> CandidateTrajectories:
        """See :meth:`PreparedSampler.sample`."""
        return self.prepare(problem, current_input).sample(warm)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedSampler:
    """A problem in the form of rollouts; it lives for one plan."""

    parameters: TrajectorySampler.Parameters
    problem: LocalProblem
    scene: RolloutScene
    weights: RolloutWeights
    likeliest: Annotated[Floats, Shape("n N+1 2")]
    """Most likely positions of each person."""

    def sample(self, warm: Trajectory | None = None) -> CandidateTrajectories:
        """The best sampled trajectories of different homotopy classes, cheapest first.

        Args:
            warm: the last plan from now on, which is perturbed as well.
        """
        p, scene = self.parameters, self.scene
        coarse = coarser(scene, p.stride)
        m = len(scene.robot.current_input)
        previous = np.empty((0, m)) if warm is None else warm.inputs[: scene.steps]
        arcs = search_arcs(
            coarse,
            _weights(p, self.problem, coarse),
            _averaged(previous, p.stride),
            arc_table(p.count),
            perturbations(p.perturbations),
            SearchBudget(p.rounds, p.elite, p.cost_window, _EXAMINED),
        )
        trajectories = self._evaluate(np.repeat(arcs, p.stride, axis=1))
        if len(previous):
            first = self._evaluate(previous[None].copy())
            trajectories = _map_arrays(lambda a, b: np.concatenate([a, b]), first, trajectories)
        order = np.argsort(trajectories.cost, kind="stable")
        chosen = _of_different_classes(trajectories.passing_sides, order, p.max_classes)
        return _map_arrays(lambda array: array[chosen], trajectories)

    def evaluate(self, inputs: Floats) -> CandidateTrajectories:
        """Any trajectories with their costs, in the given order.

        Args:
            inputs: (k, L, m) or (L, m); beyond L steps a trajectory leads back to the path.
        """
        return self._evaluate(np.array(inputs, dtype=float, ndmin=3))

    def _evaluate(self, inputs: Floats) -> CandidateTrajectories:
        scene = self.scene
        count, m = len(inputs), inputs.shape[2]
        limited = np.empty((count, scene.steps, m))
        poses = np.empty((count, scene.steps + 1, 3))
        results = evaluate_inputs(scene, self.weights, inputs[:, : scene.steps], limited, poses)
        sides = passing_sides(poses, self.likeliest, scene.path)
        preferred = _SIDES[self.problem.profile.passing_side]
        wrong = (sides[:, 1:] == -preferred).sum(axis=1) if preferred else 0
        return CandidateTrajectories(
            step=scene.step,
            inputs=limited,
            poses=poses,
            cost=results[:, 0] + self.parameters.passing_side * wrong,
            contact=results[:, 1],
            passing_sides=sides,
        )


def _likeliest(problem: LocalProblem, scene: RolloutScene) -> Floats:
    """Most likely positions of each person, (n, N+1, 2)."""
    people, hypotheses = problem.predictions.weight.shape
    likely = problem.predictions.weight.argmax(axis=1) if people else np.empty(0, np.int64)
    rows = hypotheses * np.arange(people) + likely
    return np.ascontiguousarray(scene.people.states[rows, :, :2])


def _weights(
    p: TrajectorySampler.Parameters, problem: LocalProblem, scene: RolloutScene
) -> RolloutWeights:
    stalled = problem.stalled
    initial, growth = (p.stalled_margin, 0.0) if stalled else (p.margin, p.growth)
    if p.oncoming_margin > 0.0 and not stalled:
        growth += p.oncoming_margin * oncoming_share(problem.people, problem.pose)
    upper = max(initial, 0.0 if stalled else p.max_margin)
    fade, margin = _by_time(scene.step, scene.steps, p.decay_time, initial, growth, upper)
    derived: dict[str, Any] = {
        "fade": fade,
        "margin": margin,
        "standing_margin": initial
        if p.standing_margin is None
        else min(initial, p.standing_margin),
        "max_margin": upper,
        "clearance": p.wall_clearance + problem.profile.clearance,
    }
    same = {name: getattr(p, name) for name in RolloutWeights._fields if name not in derived}
    return RolloutWeights(**same, **derived)


@functools.lru_cache(maxsize=64)
def _by_time(
    step: float, steps: int, decay: float, initial: float, growth: float, upper: float
) -> tuple[Floats, Floats]:
    """(fade, margin) of ``RolloutWeights``; constant without an oncoming margin."""
    time = step * np.arange(steps + 1)
    return np.exp(-time / decay), np.minimum(initial + growth * time, upper)


@njit(cache=True)
def _of_different_classes(sides: Integers, order: Integers, count: int) -> Integers:
    """The first ``count`` of ``order`` with pairwise different rows of ``sides`` (k, 1 + n)."""
    chosen = np.empty(count, np.int64)
    n = 0
    for candidate in order:
        if n == count:
            break
        known = False
        for c in range(n):
            known |= np.array_equal(sides[candidate], sides[chosen[c]])
        if not known:
            chosen[n] = candidate
            n += 1
    return chosen[:n]


def _map_arrays(
    function: Callable[..., NDArray[Any]], *given: CandidateTrajectories
) -> CandidateTrajectories:
    """Apply a function to each array of some trajectories."""
    names = ("inputs", "poses", "cost", "contact", "passing_sides")
    arrays = {name: function(*(getattr(each, name) for each in given)) for name in names}
    return CandidateTrajectories(step=given[0].step, **arrays)


def _averaged(inputs: Floats, stride: int) -> Floats:
    """Inputs (L, m) averaged over ``stride`` at a time; an incomplete last part is dropped."""
    whole = len(inputs) // stride
    return np.asarray(inputs[: whole * stride].reshape(whole, stride, inputs.shape[1]).mean(axis=1))
