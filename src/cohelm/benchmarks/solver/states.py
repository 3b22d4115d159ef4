"""States along rides among people, on which solvers are compared."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.benchmarks.solver.comparison import along
from cohelm.config import override, validate
from cohelm.control import LocalProblem, SsMpcDcbf, Trajectory
from cohelm.control.trajectories import limited_trajectory
from cohelm.control.warm_start import estimate_current_input
from cohelm.errors import ConfigError
from cohelm.messages import LocalPlan, Predictions, Reference
from cohelm.stopwatch import Stopwatch
from cohelm.testing.problems import RandomProblem, problem_of

TICK = 0.05
"""Interval of two plans, s."""
TICKS = 40
"""Plans per ride."""
FUTURES = {"keeps_going": 0.5, "stops": 0.3, "turns_back": 0.2}
"""Hypotheses of every person where there are three, with probabilities; all of them bind."""

PLANNER, BY_ROW = "local_planner", {"use", "steps", "candidates"}
"""Part that can be set, and those of its parameters that the rows vary."""

_FINE = 0.01
_BUDGET = 3
"""Quadratic programs per tick of a ride that the solver alone drives."""


@value
class RideState:
    """One tick of a ride."""

    problem: LocalProblem
    half_planes: Annotated[Floats, Shape("w 3")]
    """Walls for the oracle: free where n·p > b, rows (n_x, n_y, b)."""
    previous: LocalPlan | None
    seed: Trajectory
    """Warm start: the last plan from now on, else along the reference."""
    time: float = 0.0
    """Thread CPU time of the planner's own plan, s."""


def ride(planner: SsMpcDcbf, drawn: RandomProblem, steps: int) -> Iterator[RideState]:
    """Ride of a chair that executes its plans, tick by tick; people keep their velocities.

    Args:
        planner: makes the plans.
        drawn: first problem, with the planner's lookahead or more.
        steps: N of the warm starts.
    """
    problem, previous, path = drawn.problem, None, _path(drawn.problem)
    for k in range(TICKS):
        current_input = estimate_current_input(problem, previous)
        near = problem.truncated(planner.steps)
        watch = Stopwatch()
        plan = planner.plan(near, previous)
        elapsed = watch.elapsed()
        yield RideState(
            problem=problem,
            half_planes=drawn.half_planes,
            previous=previous,
            seed=seed(problem.truncated(steps), previous, current_input),
            time=elapsed,
        )
        previous = plan
        problem = _moved(problem, previous.command, path, (k + 1) * TICK)


def solved_ride(planner: SsMpcDcbf, drawn: RandomProblem) -> Iterator[RideState]:
    """Ride driven by the planner's solver alone, without sampling and verification."""
    problem, path = drawn.problem, _path(drawn.problem)
    warm = seed(problem, None, problem.robot.motion_model.input(problem.twist))
    for k in range(TICKS):
        yield RideState(problem=problem, half_planes=drawn.half_planes, previous=None, seed=warm)
        found = planner.control.solve(problem, warm, iterations=_BUDGET).trajectory
        command = problem.robot.motion_model.twist(found.inputs[0])
        problem = _moved(problem, command, path, (k + 1) * TICK)
        warm = limited_trajectory(problem, later(found.inputs, found.step, TICK), found.inputs[0])


def planner_with(settings: Sequence[str]) -> SsMpcDcbf:
    """Create the planner with ``local_planner.parameter=value`` settings.

    Raises:
        ConfigError: if it has no such parameter, or the rows vary it.
    """
    given = override({}, settings)
    for key in given:
        if key != PLANNER:
            raise ConfigError(f"only {PLANNER}.… can be set here", key=key)
    of_planner = override({PLANNER: {}}, settings)[PLANNER]
    if not isinstance(of_planner, dict):
        raise ConfigError(f"name a parameter, as {PLANNER}.iterations=5", key=PLANNER)
    for key in BY_ROW & of_planner.keys():
        raise ConfigError("is set by the rows and cannot be changed", key=f"{PLANNER}.{key}")
    return SsMpcDcbf(validate(SsMpcDcbf.Parameters, of_planner, prefix=PLANNER))


def seed(problem: LocalProblem, previous: LocalPlan | None, current_input: Floats) -> Trajectory:
    """Last plan from now on, extended or cut; without one, along the reference."""
    reference = problem.reference
    if previous is None:
        return along(problem, current_input)
    inputs = later(previous.inputs, previous.step, problem.time - previous.time)
    steps = len(reference.speeds) - 1
    inputs = inputs[np.minimum(np.arange(steps), len(inputs) - 1)]
    return limited_trajectory(problem, inputs, current_input)


def later(inputs: Floats, step: float, elapsed: float) -> Floats:
    """Inputs (N, m) from ``elapsed`` s on, interpolated; the last one is held."""
    times = step * np.arange(len(inputs))
    return np.stack([np.interp(times + elapsed, times, column) for column in inputs.T], axis=-1)


def with_futures(problem: LocalProblem) -> LocalProblem:
    """Problem with three hypotheses per person: continues, stops, turns back."""
    p = problem.predictions
    keep = p.velocity[:, 0, 0]
    velocity = np.stack([keep, 0.0 * keep, -keep], axis=1)[:, :, None]
    ahead = p.step * np.arange(p.mean.shape[2])
    predictions = Predictions(
        step=p.step,
        names=tuple(FUTURES),
        weight=np.tile(list(FUTURES.values()), (len(p.weight), 1)),
        mean=p.mean[:, :1, :1] + velocity * ahead[:, None],
        velocity=np.broadcast_to(velocity, (len(p.weight), 3, len(ahead), 2)),
        deviation=np.repeat(p.deviation, 3, axis=1),
    )
    return problem_of(
        robot=problem.robot,
        pose=problem.pose,
        twist=problem.twist,
        reference=problem.reference,
        people=problem.people,
        walls=problem.walls,
        time=problem.time,
        predictions=predictions,
    )


def _moved(problem: LocalProblem, command: Floats, path: Floats, at: float) -> LocalProblem:
    inputs = problem.robot.motion_model.input(command)[None]
    pose = problem.robot.motion_model.rollout(problem.pose, inputs, TICK)[-1]
    mean = problem.people.mean.copy()
    mean[:, :2] += TICK * mean[:, 2:]
    return problem_of(
        robot=problem.robot,
        pose=pose,
        twist=command,
        reference=_ahead(path, pose, problem.reference),
        people=dataclasses.replace(problem.people, mean=mean, time=at),
        walls=problem.walls,
        time=at,
    )


def _path(problem: LocalProblem) -> Floats:
    """Reference (k, 3) at steps of ``_FINE`` s, as far as a ride needs it."""
    reference = problem.reference
    bend = (reference.poses[1, 2] - reference.poses[0, 2]) / reference.step
    count = round((TICKS * TICK + len(reference.speeds) * reference.step) / _FINE)
    inputs = np.tile([reference.speeds[0], bend], (count, 1))
    return problem.robot.motion_model.rollout(reference.poses[0], inputs, _FINE)


def _ahead(path: Floats, pose: Floats, like: Reference) -> Reference:
    """Reference from the point of the path nearest to ``pose`` on."""
    nearest = int(np.hypot(*(path[:, :2] - pose[:2]).T).argmin())
    index = nearest + np.arange(len(like.speeds)) * round(like.step / _FINE)
    return dataclasses.replace(like, poses=path[np.minimum(index, len(path) - 1)])
