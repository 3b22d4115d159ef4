"""Oracle of ``ss_mpc_dcbf``: the local problem as a symbolic program for CasADi and IPOPT.

Written from the equations and not from the solver: direct multiple shooting with the states as
variables, the barriers as functions of pose and person, one slack for each person and kind of
barrier, and one for all walls,

    minimise   cost(x, u) + Σ l1·s + ½ l2·s²
    subject to x_{k+1} = f(x_k, u_k),  h_{k+1} − (1 − γ) h_k + s ≥ 0,  s ≥ 0,  limits on u and Δu

so that both must find equal optima; terms and barriers are in ``oracle_terms``. The projection on
the sampled path is piecewise linear: a program has the segment of each state as a parameter, and is
solved again while its solution lies on other segments. Needs the extra ``bench``; CasADi is
imported when first used. A program is built once for each structure, and then parametrised.
"""

from __future__ import annotations

import functools
import importlib
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.benchmarks.solver.oracle_terms import (
    Footprint,
    Hinges,
    ProgramSize,
    barriers,
    cost_of,
    hinged,
)
from cohelm.control import LocalProblem, OptimalControl
from cohelm.control.path import SPACING, path_table, project_on_path
from cohelm.control.stack import Terms
from cohelm.stopwatch import Stopwatch

_FREE = np.inf
_ROUNDING = 1e-6
_ROUNDS = 3
"""Maximum number of programs with other segments of the path."""
_DECAY_TIME = 4.0
"""Time constant with which the weight of predictions decays, s."""
_BRISK = 0.5
"""Speed of a person from which the clearance counts in full, m/s."""
_AHEAD = round(2.0 / SPACING)
"""Lookahead of the final heading, in samples of the path."""


@value
class OracleSolution:
    """Solution of IPOPT."""

    inputs: Annotated[Floats, Shape("N 2")]
    poses: Annotated[Floats, Shape("N+1 3")]
    cost: float
    """Including the prices of the barriers, on the segments of the solution, s."""
    status: str
    """Status text of IPOPT."""
    solved: bool
    settled: bool
    """True where the solution lies on the segments of its program."""
    iterations: int
    time: float
    """Thread CPU time of the first program alone, s."""


def solve(
    problem: LocalProblem,
    control: OptimalControl,
    half_planes: Floats,
    *,
    current_input: Floats | None = None,
    start: Floats | None = None,
) -> OracleSolution:
    """Solve the problem of ``control`` by IPOPT.

    Args:
        problem: of a unicycle; its distance field is not used.
        control: terms, barriers and clearance.
        half_planes: walls, (w, 3): free where n·p > b, |n| = 1.
        current_input: (v, ω) of the wheels; None: from odometry.
        start: initial inputs (N, 2); None: those along the reference.

    Raises:
        ModuleNotFoundError: without CasADi.
        ValueError: for a problem of another kind, or with terms of one's own.
    """
    model = problem.robot.motion_model
    if model.inputs != 2 or model.turned or control.extra_terms or control.norm != 2:
        raise ValueError("the oracle solves problems of a unicycle without terms of one's own")
    current_input = problem.twist[[0, 2]] if current_input is None else current_input
    inputs = _along(problem) if start is None else start
    size = ProgramSize.of(problem, control.terms, len(half_planes))
    program = _built(control.terms, Footprint.of(problem.robot), size)
    values, n = _values(problem, control, current_input, half_planes), size.steps
    poses, slack = model.rollout(problem.pose, inputs, size.step), np.full(program.slacks, 0.1)
    segments, first = _segments(problem, control, poses), None
    for _ in range(_ROUNDS):
        x0 = np.concatenate([poses[1:].ravel(), inputs.ravel(), slack])
        limits = _limits(problem, control.tick, current_input, program)
        watch = Stopwatch()
        found = program.solver(x0=x0, p=np.concatenate([values, segments.free]), **limits)
        elapsed, stats = watch.elapsed(), program.solver.stats()
        first = elapsed if first is None else first
        x = np.asarray(found["x"]).ravel()
        inputs, slack = x[3 * n : 5 * n].reshape(n, 2), x[5 * n :]
        poses = np.vstack([problem.pose, x[: 3 * n].reshape(n, 3)])
        before, segments = segments, _segments(problem, control, poses)
        settled = bool((before.samples == segments.samples).all())
        if settled or not stats["success"]:
            break
    return OracleSolution(
        inputs=inputs,
        poses=poses,
        cost=float(program.account(x[: 5 * n], np.concatenate([values, segments.exact]))),
        status=stats["return_status"],
        solved=bool(stats["success"]),
        settled=settled,
        iterations=int(stats["iter_count"]),
        time=float(first or 0.0),
    )


def _along(problem: LocalProblem) -> Floats:
    """Inputs (N, 2) along the reference."""
    reference = problem.reference
    turn = np.diff(reference.poses[:, 2]) / reference.step
    return np.column_stack([reference.speeds[:-1], turn])


class _Segments(NamedTuple):
    """Segments of the path on which the states of a trajectory are projected."""

    samples: Integers
    """(N+1,) sample of the path at which each segment begins."""
    free: Floats
    """Parameters of a program, in the order of ``_symbols``: the segments have no ends."""
    exact: Floats
    """The same with ends, for the cost of this trajectory: s is constant beyond an end."""


def _segments(problem: LocalProblem, control: OptimalControl, poses: Floats) -> _Segments:
    """The segments of poses (N+1, 3)."""
    steps = len(poses) - 1
    path = path_table(problem.reference, problem.top_speed, steps)
    index, i = np.zeros(steps + 1, dtype=np.int64), 0
    for k, (x, y, _) in enumerate(poses.tolist()):
        i, _, _ = project_on_path(path.samples, x, y, i)
        index[k] = i
    origin, tangent = path.samples[index, :2], path.samples[index, 2:]
    along = ((poses[:, :2] - origin) * tangent).sum(axis=1)
    within = (along > 0.0) & (along < SPACING)
    end = np.clip(along, 0.0, SPACING)
    aim = min(index[-1] + _AHEAD, len(path.samples) - 1)
    forward = 1.0 if float(path.heading[index[-1]] @ tangent[-1]) >= 0.0 else -1.0
    common = [path.reference, origin.T.ravel(), tangent.T.ravel()]
    last = [path.samples[aim, :2], [forward]]
    arc, ones = SPACING * index, np.ones(steps + 1)
    return _Segments(
        samples=index,
        free=np.concatenate([*common, arc, ones, *last]),
        exact=np.concatenate([*common, arc + np.where(within, 0.0, end), within, *last]),
    )


def _limits(
    problem: LocalProblem, tick: float, current_input: Floats, program: _Program
) -> dict[str, Floats]:
    """Bounds of the variables and of the constraints; the first Δu must fit within a tick.

    An input beyond a bound may return to it as fast as the acceleration limits allow. Else the plan
    brakes with three quarters of the comfort deceleration, and the acceleration begins at 0 and
    grows with the limit of jerk in the first tick, unless a bound of the speed is in the way.
    """
    robot, n = problem.robot, len(problem.reference.speeds) - 1
    durations = np.full((n, 1), problem.reference.step)
    durations[0] = tick
    since = durations.cumsum(axis=0)
    faster = np.array([robot.max_acceleration, robot.max_turn_acceleration])
    slower = np.array([robot.max_deceleration, robot.max_turn_acceleration])
    bottom, top, _, _ = problem.input_bounds()
    calm = current_input[0] <= top[0] + _ROUNDING
    slower *= [0.75 if calm else 1.0, 1.0]
    rise, fall = faster * durations, slower * durations
    if calm:
        first, now = robot.max_jerk * tick**2, current_input[0]
        rise[0, 0] = max(min(rise[0, 0], first), bottom[0] - now)
        fall[0, 0] = max(min(fall[0, 0], first), now - top[0])
    low = np.minimum(bottom, current_input + since * faster)
    high = np.maximum(top, current_input - since * slower)
    free, none = np.full(3 * n, _FREE), np.zeros(3 * n)
    return {
        "lbx": np.concatenate([-free, low.ravel(), np.zeros(program.slacks)]),
        "ubx": np.concatenate([free, high.ravel(), np.full(program.slacks, _FREE)]),
        "lbg": np.concatenate([none, -fall.ravel(), np.zeros(program.soft)]),
        "ubg": np.concatenate([none, rise.ravel(), np.full(program.soft, _FREE)]),
    }


@dataclass(frozen=True, slots=True)
class _Program:
    """A solver with its numbers of slacks and soft rows."""

    solver: Any
    account: Any
    """Cost of given states and inputs with the smallest slacks."""
    slacks: int
    """Slacks and hinges."""
    soft: int


def _values(
    problem: LocalProblem, control: OptimalControl, current_input: Floats, half_planes: Floats
) -> Floats:
    """Values of the parameters, in the order of ``_symbols``, without those of the segments."""
    spaces, predictions, steps = problem.spaces, problem.predictions, len(problem.reference.speeds)
    hypotheses = (
        predictions.mean[..., 0],
        predictions.mean[..., 1],
        _margins(problem, control),
        spaces.axis,
        spaces.front,
        spaces.side,
        spaces.rear,
    )
    groups = [] if spaces.groups is None else [spaces.groups.direction, spaces.groups.support]
    creep = max(min(0.3, problem.top_speed), 0.05)
    return np.concatenate(
        [
            problem.pose,
            current_input,
            problem.reference.poses.T.ravel(),
            problem.reference.speeds,
            *(a.ravel() for a in hypotheses),
            problem.people.radius,
            predictions.weight.ravel(),
            np.exp(-problem.reference.step * np.arange(steps) / _DECAY_TIME),
            [spaces.floor, spaces.robot_floor, problem.profile.clearance, spaces.scale],
            [max(float(problem.reference.speeds.max()), creep)],
            spaces.robot,
            half_planes.ravel(),
            *(a.ravel() for a in groups),
        ]
    )


def _margins(problem: LocalProblem, control: OptimalControl) -> Floats:
    """m(t) = s(v)·min(now + (growth + oncoming·o)·t + deviations·σ, upper) + extra, (n, h, N+1)."""
    c, predictions, extra = control.clearance, problem.predictions, problem.extra_clearance
    age = problem.reference.step * np.arange(predictions.mean.shape[2])
    speed = np.hypot(*np.moveaxis(predictions.velocity[:, :, :1], -1, 0))
    walks = c.standing + (1.0 - c.standing) * np.minimum(speed / _BRISK, 1.0)
    if problem.stalled:
        return np.asarray(walks * np.full_like(predictions.deviation, c.now) + extra)
    growth = c.growth + c.oncoming * _oncoming(problem)
    gap = c.now + growth * age + c.deviations * predictions.deviation
    return np.asarray(walks * np.minimum(gap, max(c.upper, c.now)) + extra)


def _oncoming(problem: LocalProblem) -> float:
    """Mean of the people's shares towards the robot over their number; see ``clearance``."""
    velocity = problem.people.mean[:, 2:]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    walks = np.minimum(speed / _BRISK, 1.0)
    if walks.sum() == 0.0:
        return 0.0
    heading = np.array([math.cos(problem.pose[2]), math.sin(problem.pose[2])])
    towards = np.maximum(-(velocity @ heading) / np.maximum(speed, 1e-12), 0.0)
    return float(walks @ towards / walks.sum() / max(walks.sum(), 1.0))


def _symbols(ca: Any, z: ProgramSize) -> dict[str, Any]:
    """Parameters in the order of ``_values`` and ``_segments``; CasADi fills by columns."""
    n, hypotheses = z.steps, z.people * z.hypotheses
    out = {"pose": ca.SX.sym("pose", 3), "current_input": ca.SX.sym("current_input", 2)}
    out["reference"] = ca.SX.sym("reference", n + 1, 3)
    out["speeds"] = ca.SX.sym("speeds", n + 1)
    for name in ("x", "y", "margin", "axis", "front", "side", "rear"):
        out[name] = ca.SX.sym(name, n + 1, hypotheses)
    sizes = {
        "radius": (z.people,), "weight": (hypotheses,), "fade": (n + 1,),
        "floor": (1,), "robot_floor": (1,), "clearance": (1,), "scale": (1,), "max_speed": (1,),
        "robot": (3,), "planes": (3, z.walls), "direction": (z.directions,),
        "support": (z.directions, z.groups * (n + 1)),
        "reference_arc": (n + 1,), "origin": (n + 1, 2), "tangent": (n + 1, 2),
        "arc": (n + 1,), "along": (n + 1,), "aim": (2,), "forward": (1,),
    }  # fmt: skip
    return out | {name: ca.SX.sym(name, *size) for name, size in sizes.items()}


@functools.lru_cache(maxsize=32)
def _built(w: Terms, body: Footprint, z: ProgramSize) -> _Program:
    ca = importlib.import_module("casadi")
    p = _symbols(ca, z)
    states, inputs = ca.SX.sym("x", 3, z.steps), ca.SX.sym("u", 2, z.steps)
    poses = ca.horzcat(p["pose"], states)
    before = ca.horzcat(p["current_input"], inputs[:, :-1])
    moved = poses[:, :-1] + z.step * ca.vertcat(
        inputs[0, :] * ca.cos(poses[2, :-1]), inputs[0, :] * ca.sin(poses[2, :-1]), inputs[1, :]
    )
    # hinges and slacks as variables, and as expressions for the cost of a given trajectory
    behind, missing = hinged(ca, w, body, p, poses)
    lag, wall = ca.SX.sym("lag", z.steps), ca.SX.sym("wall", z.steps)
    free, exact = Hinges(lag, wall if missing else None), Hinges(ca.fmax(behind, 0.0), None)
    if missing:
        exact = Hinges(exact.lag, functools.reduce(ca.fmax, [0.0, *missing]))
    cost, account = (
        cost_of(ca, w, body, p, z, (poses, inputs), hinges=hinges) for hinges in (free, exact)
    )
    slacks, soft = [], [lag - behind, *(wall - each for each in missing)]
    for law, series in barriers(ca, w, body, p, poses, z):
        s, needed = ca.SX.sym("s"), ca.SX(0.0)
        for h in series:
            row = h[1:] - (1.0 - law.gamma) * h[:-1]
            soft.append(row + s)
            needed = ca.fmax(needed, ca.mmax(-row))
        slacks.append(s)
        cost += law.l1 * s + 0.5 * law.l2 * s * s
        account += law.l1 * needed + 0.5 * law.l2 * needed**2
    hinges = [lag, wall] if missing else [lag]
    extra = ca.vertcat(*slacks, *hinges)
    yielding = ca.vertcat(*soft)
    parameters = ca.vertcat(*(ca.vec(symbol) for symbol in p.values()))
    solver = ca.nlpsol(
        "oracle",
        "ipopt",
        {
            "x": ca.vertcat(ca.vec(states), ca.vec(inputs), extra),
            "p": parameters,
            "f": cost,
            "g": ca.vertcat(ca.vec(states - moved), ca.vec(inputs - before), yielding),
        },
        {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 500}},
    )
    given = ca.vertcat(ca.vec(states), ca.vec(inputs))
    return _Program(
        solver,
        ca.Function("account", [given, parameters], [account]),
        int(extra.numel()),
        int(yielding.numel()),
    )
