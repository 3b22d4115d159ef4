"""States along rides among people, for solvers to be compared on: the same for all of them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Sequence

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import override, validate
from cohelm.control import LocalProblem, Motion, SsMpcDcbf
from cohelm.control.warm_start import followed, last_input
from cohelm.errors import ConfigError
from cohelm.messages import LocalPlan, Predictions, Reference
from cohelm.testing.comparison import along
from cohelm.testing.problems import RandomProblem, problem_of

TICK = 0.05
"""Between two plans, s."""
TICKS = 40
"""Plans of a ride."""
FUTURES = {"keeps_going": 0.5, "stops": 0.3, "turns_back": 0.2}
"""Hypotheses of everybody where there are three, and their probabilities: all of them bind."""

PLANNER, BY_ROW = "local_planner", {"use", "steps", "candidates"}
"""What can be set, and what of it the rows say."""

_FINE = 0.01
_BUDGET = 3
"""Quadratic programs a tick of a ride that the solver alone drives."""


@value
class State:
    """One tick of a ride."""

    problem: LocalProblem
    half_planes: Annotated[Floats, Shape("w 3")]
    """The walls, as the oracle takes them."""
    previous: LocalPlan | None
    seed: Motion
    """Where the solver starts: the last plan from now on, else along the reference."""
    took: float = 0.0
    """Thread CPU time of the planner's own plan here, s."""


def ride(planner: SsMpcDcbf, drawn: RandomProblem, steps: int) -> Iterator[State]:
    """A chair that does what is planned, tick by tick; people keep their velocities.

    Args:
        planner: whose plans are driven.
        drawn: where the ride begins, with the planner's lookahead or more.
        steps: N of the seeds.
    """
    problem, previous, way = drawn.problem, None, _path(drawn.problem)
    for k in range(TICKS):
        now = last_input(problem, previous)
        near = problem.within(planner.steps)
        begin = time.thread_time()
        plan = planner.plan(near, previous)
        took = time.thread_time() - begin
        yield State(
            problem=problem,
            half_planes=drawn.half_planes,
            previous=previous,
            seed=seed(problem.within(steps), previous, now),
            took=took,
        )
        previous = plan
        problem = _moved(problem, previous.command, way, (k + 1) * TICK)


def solved_ride(planner: SsMpcDcbf, drawn: RandomProblem) -> Iterator[State]:
    """The same, driven by the planner's solver alone, without search and verification."""
    problem, way = drawn.problem, _path(drawn.problem)
    warm = seed(problem, None, problem.robot.motion.input(problem.twist))
    for k in range(TICKS):
        yield State(problem=problem, half_planes=drawn.half_planes, previous=None, seed=warm)
        found = planner.control.solve(problem, warm, iterations=_BUDGET).motion
        command = problem.robot.motion.twist(found.inputs[0])
        problem = _moved(problem, command, way, (k + 1) * TICK)
        warm = followed(problem, later(found.inputs, found.step, TICK), found.inputs[0])


def planner_with(settings: Sequence[str]) -> SsMpcDcbf:
    """The planner as it comes, but for ``local_planner.parameter=value`` settings.

    Raises:
        ConfigError: if it has no such parameter, or what is compared says it.
    """
    given = override({}, settings)
    for key in given:
        if key != PLANNER:
            raise ConfigError(f"only {PLANNER}.… can be set here", key=key)
    of_planner = override({PLANNER: {}}, settings)[PLANNER]
    if not isinstance(of_planner, dict):
        raise ConfigError(f"name a parameter, as {PLANNER}.iterations=5", key=PLANNER)
    for key in BY_ROW & of_planner.keys():
        raise ConfigError("is said by the rows here, and cannot be set", key=f"{PLANNER}.{key}")
    return SsMpcDcbf(validate(SsMpcDcbf.Parameters, of_planner, prefix=PLANNER))


def seed(problem: LocalProblem, previous: LocalPlan | None, now: Floats) -> Motion:
    """The last plan from now on, lengthened or cut; without one, along the reference."""
    reference = problem.reference
    if previous is None:
        return along(problem, now)
    inputs = later(previous.inputs, previous.step, problem.time - previous.time)
    steps = len(reference.speeds) - 1
    inputs = inputs[np.minimum(np.arange(steps), len(inputs) - 1)]
    return followed(problem, inputs, now)


def later(inputs: Floats, step: float, elapsed: float) -> Floats:
    """Inputs (N, m) from ``elapsed`` s on, interpolated; the last one lasts."""
    times = step * np.arange(len(inputs))
    return np.stack([np.interp(times + elapsed, times, column) for column in inputs.T], axis=-1)


def with_futures(problem: LocalProblem) -> LocalProblem:
    """The same problem, in which everybody keeps going, stops or turns back."""
    p = problem.predictions
    now = p.velocity[:, 0, 0]
    velocity = np.stack([now, 0.0 * now, -now], axis=1)[:, :, None]
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


def _moved(problem: LocalProblem, command: Floats, way: Floats, at: float) -> LocalProblem:
    inputs = problem.robot.motion.input(command)[None]
    pose = problem.robot.motion.rollout(problem.pose, inputs, TICK)[-1]
    mean = problem.people.mean.copy()
    mean[:, :2] += TICK * mean[:, 2:]
    return problem_of(
        robot=problem.robot,
        pose=pose,
        twist=command,
        reference=_ahead(way, pose, problem.reference),
        people=dataclasses.replace(problem.people, mean=mean, time=at),
        walls=problem.walls,
        time=at,
    )


def _path(problem: LocalProblem) -> Floats:
    """The reference (k, 3) at steps of ``_FINE`` s, as far on as a ride needs it."""
    reference = problem.reference
    bend = (reference.poses[1, 2] - reference.poses[0, 2]) / reference.step
    count = round((TICKS * TICK + len(reference.speeds) * reference.step) / _FINE)
    inputs = np.tile([reference.speeds[0], bend], (count, 1))
    return problem.robot.motion.rollout(reference.poses[0], inputs, _FINE)


def _ahead(way: Floats, pose: Floats, like: Reference) -> Reference:
    """From the way's point nearest to ``pose`` on."""
    nearest = int(np.hypot(*(way[:, :2] - pose[:2]).T).argmin())
    index = nearest + np.arange(len(like.speeds)) * round(like.step / _FINE)
    return dataclasses.replace(like, poses=way[np.minimum(index, len(way) - 1)])
