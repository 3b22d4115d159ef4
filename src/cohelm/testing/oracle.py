"""The local problem once more, symbolically, for CasADi and IPOPT: the oracle of ``ss_mpc_dcbf``.

Written from the equations and not from the solver: direct multiple shooting with the states as
variables, the barriers as functions of pose and person, one slack for each person and each disc,

    minimise   cost(x, u) + Σ l1·s + ½ l2·s²
    subject to x_{k+1} = f(x_k, u_k),  h_{k+1} − (1 − γ) h_k + s ≥ 0,  s ≥ 0,  limits on u and Δu

so that both must find the same optima. Needs the extra ``bench``; CasADi is imported when first
used. A program is built once for each number of steps, people and walls, and then parametrised.
"""

from __future__ import annotations

import functools
import importlib
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control import LocalProblem, SsMpcDcbf
from cohelm.robots import Robot
from cohelm.shapes import PRINTED

_SMOOTH = 1e-6
_FREE = np.inf


@value
class OracleSolution:
    """Where IPOPT ended."""

    inputs: Annotated[Floats, Shape("N 2")]
    poses: Annotated[Floats, Shape("N+1 3")]
    cost: float
    """Slack's price included."""
    status: str
    """IPOPT's own word."""
    solved: bool
    iterations: int
    time: float
    """Thread CPU time of the solve alone, s."""


def solve(
    problem: LocalProblem,
    parameters: SsMpcDcbf.Parameters,
    half_planes: Floats,
    *,
    last_input: Floats | None = None,
    start: Floats | None = None,
) -> OracleSolution:
    """IPOPT's solution of what ``SsMpcDcbf(parameters)`` solves.

    Args:
        problem: one hypothesis a person, a unicycle, not stalled; its distance field is not used.
        parameters: of the planner.
        half_planes: the walls, (w, 3): free where n·p > b, |n| = 1.
        last_input: (v, ω) of the wheels; None: as odometry says.
        start: inputs (N, 2) to start from; None: those that lead along the reference.

    Raises:
        ModuleNotFoundError: without CasADi.
        ValueError: for a problem of another kind.
    """
    now = problem.twist[[0, 2]] if last_input is None else last_input
    program = _built(
        parameters,
        _Footprint.of(problem.robot),
        len(problem.reference.speeds) - 1,
        len(problem.people),
        len(half_planes),
        problem.spaces.kind,
    )
    inputs = _along(problem) if start is None else start
    poses = problem.robot.motion.rollout(problem.pose, inputs, problem.reference.step)
    low, high = _input_limits(problem, parameters, now)
    begin = time.thread_time()
    found = program.solver(
        x0=np.concatenate([poses[1:].ravel(), inputs.ravel(), np.full(program.slacks, 0.1)]),
        p=_values(problem, now, half_planes),
        lbx=np.concatenate([np.full(poses[1:].size, -_FREE), low[0], np.zeros(program.slacks)]),
        ubx=np.concatenate(
            [np.full(poses[1:].size, _FREE), high[0], np.full(program.slacks, _FREE)]
        ),
        lbg=np.concatenate([np.zeros(poses[1:].size), low[1], np.zeros(program.soft)]),
        ubg=np.concatenate([np.zeros(poses[1:].size), high[1], np.full(program.soft, _FREE)]),
    )
    took = time.thread_time() - begin
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
        time=took,
    )


def _along(problem: LocalProblem) -> Floats:
    """Inputs (N, 2) along the reference."""
    reference = problem.reference
    turn = np.diff(reference.poses[:, 2]) / reference.step
    return np.column_stack([reference.speeds[:-1], turn])


def _input_limits(
    problem: LocalProblem, parameters: SsMpcDcbf.Parameters, now: Floats
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """((lowest u, lowest Δu), (highest u, highest Δu)), (2N,) each; the first Δu within a tick.

    Who is beyond a bound may come back to it as fast as the acceleration limits let him.
    """
    robot, n = problem.robot, len(problem.reference.speeds) - 1
    durations = np.full((n, 1), problem.reference.step)
    durations[0] = parameters.input_limits.tick
    since = durations.cumsum(axis=0)
    faster = np.array([robot.max_acceleration, robot.max_turn_acceleration])
    slower = np.array([robot.max_deceleration, robot.max_turn_acceleration])
    bottom, top, _, _ = problem.input_bounds()
    low = np.minimum(bottom, now + since * faster)
    high = np.maximum(top, now - since * slower)
    return (
        (low.ravel(), (-slower * durations).ravel()),
        (high.ravel(), (faster * durations).ravel()),
    )


@dataclass(frozen=True, slots=True)
class _Footprint:
    """``Robot.capsule`` and ``Robot.discs`` as a key."""

    capsule: tuple[float, ...]
    discs: tuple[tuple[float, float, float], ...]

    @staticmethod
    def of(robot: Robot) -> _Footprint:
        """A robot's."""
        return _Footprint(tuple(robot.capsule.tolist()), tuple(map(tuple, robot.discs.tolist())))


@dataclass(frozen=True, slots=True)
class _Program:
    """A solver, how many slacks it has and how many soft rows."""

    solver: Any
    slacks: int
    soft: int


def _values(problem: LocalProblem, now: Floats, half_planes: Floats) -> Floats:
    """The values of the parameters, in the order in which ``_symbols`` declares them."""
    spaces, predictions = problem.spaces, problem.predictions
    if predictions.mean.shape[1] != 1 or problem.stalled:
        raise ValueError("the oracle knows one hypothesis a person, and no stalled ride")
    people = [predictions.mean[:, 0, :, 0], predictions.mean[:, 0, :, 1]]
    people += [a[:, 0] for a in (spaces.axis, spaces.front, spaces.side, spaces.rear)]
    return np.concatenate(
        [
            problem.pose,
            now,
            problem.reference.poses.T.ravel(),
            problem.reference.speeds,
            *(a.ravel() for a in people),
            problem.people.radius,
            [spaces.floor, spaces.robot_floor, problem.profile.clearance, spaces.scale],
            spaces.robot,
            half_planes.ravel(),
        ]
    )


def _symbols(ca: Any, n: int, people: int, walls: int) -> dict[str, Any]:
    """The parameters, in the order of ``_values``; CasADi fills matrices column by column."""
    out = {"pose": ca.SX.sym("pose", 3), "now": ca.SX.sym("now", 2)}
    out["reference"] = ca.SX.sym("reference", n + 1, 3)
    out["speeds"] = ca.SX.sym("speeds", n + 1)
    for name in ("x", "y", "axis", "front", "side", "rear"):
        out[name] = ca.SX.sym(name, n + 1, people)
    out["radius"] = ca.SX.sym("radius", people)
    out["floor"] = ca.SX.sym("floor")
    out["robot_floor"] = ca.SX.sym("robot_floor")
    out["clearance"] = ca.SX.sym("clearance")
    out["scale"] = ca.SX.sym("scale")
    out["robot"] = ca.SX.sym("robot", 3)
    out["planes"] = ca.SX.sym("planes", 3, walls)
    return out


@functools.lru_cache(maxsize=32)
def _built(
    w: SsMpcDcbf.Parameters, body: _Footprint, n: int, people: int, walls: int, kind: int
) -> _Program:
    ca = importlib.import_module("casadi")
    p = _symbols(ca, n, people, walls)
    states, inputs = ca.SX.sym("x", 3, n), ca.SX.sym("u", 2, n)
    poses = ca.horzcat(p["pose"], states)
    before = ca.horzcat(p["now"], inputs[:, :-1])
    moved = poses[:, :-1] + w.step * ca.vertcat(
        inputs[0, :] * ca.cos(poses[2, :-1]), inputs[0, :] * ca.sin(poses[2, :-1]), inputs[1, :]
    )
    cost = _cost(ca, w, p, states, inputs, inputs - before)
    slacks, soft = [], []
    for law, series in _barriers(ca, w, body, p, poses, kind):
        for h in series:
            s = ca.SX.sym("s")
            slacks.append(s)
            cost += law.l1 * s + 0.5 * law.l2 * s * s
            soft.append(h[1:] - (1.0 - law.gamma) * h[:-1] + s)
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


def _cost(
    ca: Any, w: SsMpcDcbf.Parameters, p: dict[str, Any], states: Any, inputs: Any, change: Any
) -> Any:
    """Xu et al., eq. (12), and the weight on changes; ½ of every square."""
    n = inputs.shape[1]
    duration = np.full((1, n), w.step)
    duration[0, -1] += w.track_reference.terminal
    error = states.T - p["reference"][1:, :]
    weights = np.array(
        [w.track_reference.position, w.track_reference.position, w.track_reference.heading]
    )
    cost = 0.5 * ca.sum1(ca.sum2((duration.T @ weights[None]) * error**2))
    wanted = p["speeds"][:-1].T if w.input_effort.input_cost == "reference" else 0.0
    cost += 0.5 * w.step * w.input_effort.speed * ca.sumsqr(inputs[0, :] - wanted)
    cost += 0.5 * w.step * w.input_effort.turn * ca.sumsqr(inputs[1, :])
    cost += 0.5 / w.step * w.smooth_input.speed * ca.sumsqr(change[0, :])
    return cost + 0.5 / w.step * w.smooth_input.turn * ca.sumsqr(change[1, :])


def _barriers(
    ca: Any, w: SsMpcDcbf.Parameters, body: _Footprint, p: dict[str, Any], poses: Any, kind: int
) -> list[tuple[Any, list[Any]]]:
    """(law, series of h over the states) for walls, bodies and social spaces."""
    states, people = poses.shape[1], p["radius"].shape[0]
    cos, sin = ca.cos(poses[2, :]).T, ca.sin(poses[2, :]).T
    x, y = poses[0, :].T, poses[1, :].T
    planes = ca.horzsplit(p["planes"])
    walls = []
    for ax, ay, radius in body.discs if planes else ():
        cx, cy = x + cos * ax - sin * ay, y + sin * ax + cos * ay
        gaps = [plane[0] * cx + plane[1] * cy - plane[2] for plane in planes]
        walls.append(functools.reduce(ca.fmin, gaps) - radius - p["clearance"])
    age = np.arange(states) * w.step
    margin = np.minimum(w.bodies.margin + w.bodies.growth * age, w.bodies.greatest)
    bodies, social = [], []
    for i in range(people):
        d, away, ahead = _seen(ca, body, poses, p["x"][:, i], p["y"][:, i])
        gap = d - body.capsule[4] - p["radius"][i]
        bodies.append(gap - margin)
        sigmas = (p["front"][:, i], p["side"][:, i], p["rear"][:, i])
        own = (p["robot"][0], p["robot"][1], p["robot"][2])
        theirs = _reach(ca, kind, sigmas, away - p["axis"][:, i], p["floor"], p["scale"])
        mine = _reach(ca, kind, own, ahead, p["robot_floor"], p["scale"])
        social.append(gap - theirs - mine)
    return [(w.wall_clearance, walls), (w.bodies, bodies), (w.social_space, social)]


def _seen(ca: Any, body: _Footprint, poses: Any, px: Any, py: Any) -> tuple[Any, Any, Any]:
    """(distance from the spine, direction from the person, direction from the robot's heading)."""
    x, y, heading = poses[0, :].T, poses[1, :].T, poses[2, :].T
    cos, sin = ca.cos(heading), ca.sin(heading)
    qx, qy = cos * (px - x) + sin * (py - y), -sin * (px - x) + cos * (py - y)
    ax, ay, bx, by, _ = body.capsule
    length2 = (bx - ax) ** 2 + (by - ay) ** 2
    share = ((qx - ax) * (bx - ax) + (qy - ay) * (by - ay)) / length2 if length2 > 0.0 else 0.0
    share = ca.fmax(0.0, ca.fmin(1.0, share))
    ex, ey = qx - ax - share * (bx - ax), qy - ay - share * (by - ay)
    ahead = ca.atan2(ey, ex)
    return ca.sqrt(ex**2 + ey**2 + _SMOOTH), ahead + heading + np.pi, ahead


def _reach(
    ca: Any, kind: int, sigmas: tuple[Any, Any, Any], delta: Any, floor: Any, scale: Any
) -> Any:
    """Xu et al., eq. (5), floored; the contour or as printed."""
    front, side, rear = sigmas
    sigma = ca.if_else(ca.cos(delta) > 0.0, front, rear)
    q = ca.cos(delta) ** 2 / (2.0 * sigma**2) + ca.sin(delta) ** 2 / (2.0 * side**2)
    length = scale / q if kind == PRINTED else ca.sqrt(scale / q)
    return ca.fmax(floor, length)
