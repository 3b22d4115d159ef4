"""Oracle of ``ss_mpc_dcbf``: the local problem as a symbolic program for CasADi and IPOPT.

Written from the equations and not from the solver: direct multiple shooting with the states as
variables, the barriers as functions of pose and person, one slack for each person and each disc,

    minimise   cost(x, u) + Σ l1·s + ½ l2·s²
    subject to x_{k+1} = f(x_k, u_k),  h_{k+1} − (1 − γ) h_k + s ≥ 0,  s ≥ 0,  limits on u and Δu

so that both must find equal optima; costs and barriers are in ``oracle_terms``. Needs the extra
``bench``; CasADi is imported when first used. A program is built once for each number of steps,
people, futures, groups and walls, and then parametrised.
"""

from __future__ import annotations

import functools
import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control import LocalProblem, OptimalControl
from cohelm.robots.contact import BRISK
from cohelm.stopwatch import Stopwatch
from cohelm.testing.oracle_terms import Footprint, ProgramSize, Terms, barriers, cost_of

_FREE = np.inf


@value
class OracleSolution:
    """Solution of IPOPT."""

    inputs: Annotated[Floats, Shape("N 2")]
    poses: Annotated[Floats, Shape("N+1 3")]
    cost: float
    """Including the slack penalty."""
    status: str
    """Status text of IPOPT."""
    solved: bool
    iterations: int
    time: float
    """Thread CPU time of the solve alone, s."""


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
        problem: of a unicycle, not stalled; its distance field is not used.
        control: cost terms and constraints.
        half_planes: walls, (w, 3): free where n·p > b, |n| = 1.
        current_input: (v, ω) of the wheels; None: from odometry.
        start: initial inputs (N, 2); None: those along the reference.

    Raises:
        ModuleNotFoundError: without CasADi.
        ValueError: for a problem of another kind.
    """
    terms = Terms.of(control, problem.reference.step)
    current_input = problem.twist[[0, 2]] if current_input is None else current_input
    program = _built(
        terms,
        Footprint.of(problem.robot),
        len(problem.reference.speeds) - 1,
        ProgramSize.of(problem, terms),
        len(half_planes),
    )
    inputs = _along(problem) if start is None else start
    poses = problem.robot.motion_model.rollout(problem.pose, inputs, problem.reference.step)
    low, high = _input_limits(problem, terms, current_input)
    watch = Stopwatch()
    found = program.solver(
        x0=np.concatenate([poses[1:].ravel(), inputs.ravel(), np.full(program.slacks, 0.1)]),
        p=_values(problem, current_input, half_planes),
        lbx=np.concatenate([np.full(poses[1:].size, -_FREE), low[0], np.zeros(program.slacks)]),
        ubx=np.concatenate(
            [np.full(poses[1:].size, _FREE), high[0], np.full(program.slacks, _FREE)]
        ),
        lbg=np.concatenate([np.zeros(poses[1:].size), low[1], np.zeros(program.soft)]),
        ubg=np.concatenate([np.zeros(poses[1:].size), high[1], np.full(program.soft, _FREE)]),
    )
    elapsed = watch.elapsed()
    stats = program.solver.stats()
    x = np.asarray(found["x"]).ravel()
    n = len(inputs)
    return OracleSolution(
        inputs=x[3 * n : 5 * n].reshape(n, 2),
        poses=np.vstack([problem.pose, x[: 3 * n].reshape(n, 3)]),
        cost=float(found["f"]),
        status=stats["return_status"],
        solved=bool(stats["success"]),
        iterations=int(stats["iter_count"]),
        time=elapsed,
    )


def _along(problem: LocalProblem) -> Floats:
    """Inputs (N, 2) along the reference."""
    reference = problem.reference
    turn = np.diff(reference.poses[:, 2]) / reference.step
    return np.column_stack([reference.speeds[:-1], turn])


def _input_limits(
    problem: LocalProblem, terms: Terms, current_input: Floats
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """((lower u, lower Δu), (upper u, upper Δu)), (2N,) each; the first Δu within a tick.

    An input beyond a bound may return to it as fast as the acceleration limits allow.
    """
    robot, n = problem.robot, len(problem.reference.speeds) - 1
    durations = np.full((n, 1), problem.reference.step)
    durations[0] = terms.input_limits.tick
    since = durations.cumsum(axis=0)
    faster = np.array([robot.max_acceleration, robot.max_turn_acceleration])
    slower = np.array([robot.max_deceleration, robot.max_turn_acceleration])
    bottom, top, _, _ = problem.input_bounds()
    low = np.minimum(bottom, current_input + since * faster)
    high = np.maximum(top, current_input - since * slower)
    return (
        (low.ravel(), (-slower * durations).ravel()),
        (high.ravel(), (faster * durations).ravel()),
    )


@dataclass(frozen=True, slots=True)
class _Program:
    """A solver with its numbers of slacks and soft rows."""

    solver: Any
    slacks: int
    soft: int


def _values(problem: LocalProblem, current_input: Floats, half_planes: Floats) -> Floats:
    """Values of the parameters, in the order of ``_symbols``."""
    spaces, predictions = problem.spaces, problem.predictions
    if problem.stalled or problem.robot.motion_model.inputs != 2:
        raise ValueError("the oracle solves problems of a unicycle that is not stalled")
    futures = (
        predictions.mean[..., 0],
        predictions.mean[..., 1],
        predictions.deviation,
        spaces.axis,
        spaces.front,
        spaces.side,
        spaces.rear,
    )
    walks = np.minimum(np.hypot(*np.moveaxis(predictions.velocity[:, :, 0], -1, 0)) / BRISK, 1.0)
    groups = [] if spaces.groups is None else [spaces.groups.direction, spaces.groups.support]
    return np.concatenate(
        [
            problem.pose,
            current_input,
            problem.reference.poses.T.ravel(),
            problem.reference.speeds,
            *(a.ravel() for a in futures),
            problem.people.radius,
            walks.ravel(),
            [spaces.floor, spaces.robot_floor, problem.profile.clearance, spaces.scale],
            spaces.robot,
            half_planes.ravel(),
            *(a.ravel() for a in groups),
        ]
    )


def _symbols(ca: Any, n: int, crowd: ProgramSize, walls: int) -> dict[str, Any]:
    """Parameters in the order of ``_values``; CasADi fills matrices column by column."""
    out = {"pose": ca.SX.sym("pose", 3), "current_input": ca.SX.sym("current_input", 2)}
    out["reference"] = ca.SX.sym("reference", n + 1, 3)
    out["speeds"] = ca.SX.sym("speeds", n + 1)
    for name in ("x", "y", "deviation", "axis", "front", "side", "rear"):
        out[name] = ca.SX.sym(name, n + 1, crowd.people * crowd.hypotheses)
    out["radius"] = ca.SX.sym("radius", crowd.people)
    out["walks"] = ca.SX.sym("walks", crowd.people * crowd.hypotheses)
    out["floor"] = ca.SX.sym("floor")
    out["robot_floor"] = ca.SX.sym("robot_floor")
    out["clearance"] = ca.SX.sym("clearance")
    out["scale"] = ca.SX.sym("scale")
    out["robot"] = ca.SX.sym("robot", 3)
    out["planes"] = ca.SX.sym("planes", 3, walls)
    out["direction"] = ca.SX.sym("direction", crowd.directions)
    out["support"] = ca.SX.sym("support", crowd.directions, crowd.groups * (n + 1))
    return out


@functools.lru_cache(maxsize=32)
def _built(w: Terms, body: Footprint, n: int, crowd: ProgramSize, walls: int) -> _Program:
    ca = importlib.import_module("casadi")
    p = _symbols(ca, n, crowd, walls)
    states, inputs = ca.SX.sym("x", 3, n), ca.SX.sym("u", 2, n)
    poses = ca.horzcat(p["pose"], states)
    before = ca.horzcat(p["current_input"], inputs[:, :-1])
    moved = poses[:, :-1] + w.step * ca.vertcat(
        inputs[0, :] * ca.cos(poses[2, :-1]), inputs[0, :] * ca.sin(poses[2, :-1]), inputs[1, :]
    )
    cost = cost_of(ca, w, p, poses, inputs)
    slacks, soft = [], []
    for law, groups in barriers(ca, w, body, p, poses, crowd):
        for group in groups:
            s = ca.SX.sym("s")
            slacks.append(s)
            cost += law.l1 * s + 0.5 * law.l2 * s * s
            soft += [h[1:] - (1.0 - law.gamma) * h[:-1] + s for h in group]
    yielding = ca.vertcat(*soft)
    solver = ca.nlpsol(
        "oracle",
        "ipopt",
        {
            "x": ca.vertcat(ca.vec(states), ca.vec(inputs), *slacks),
            "p": ca.vertcat(*(ca.vec(symbol) for symbol in p.values())),
            "f": cost,
            "g": ca.vertcat(ca.vec(states - moved), ca.vec(inputs - before), yielding),
        },
        {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 500}},
    )
    return _Program(solver, len(slacks), int(yielding.numel()))
