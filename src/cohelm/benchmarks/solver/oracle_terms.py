"""Terms and barriers of the oracle, from their equations, in CasADi's symbols.

States are columns: poses (3, N+1), inputs (2, N). ``p`` are the symbols of ``oracle``.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Booleans
from cohelm.control import LocalProblem
from cohelm.control.stack import Terms
from cohelm.control.terms import Barrier, InputDeviation, WallBarrier
from cohelm.robots import Robot
from cohelm.shapes import ELLIPSE, PRINTED

_SMOOTH = 1e-6
"""Added to squared distances from the spine, m²."""
_ROUNDED = 1e-3
"""Distance from the end of the reference at which its norm is rounded, m."""
_SATURATED = 1.0
"""Upper bound of h, m."""
_SPACES_FROM = 0.3
"""Probability from which the space of a hypothesis that is not the most likely one binds."""
_STANDS = 0.2
"""Speed from which the robot is fully responsible, m/s."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """``Robot.capsule`` and ``Robot.discs`` as a key."""

    capsule: tuple[float, ...]
    discs: tuple[tuple[float, float, float], ...]

    @staticmethod
    def of(robot: Robot) -> Footprint:
        """Footprint of a robot."""
        return Footprint(tuple(robot.capsule.tolist()), tuple(map(tuple, robot.discs.tolist())))


@dataclass(frozen=True, slots=True)
class ProgramSize:
    """Structure of a program: numbers of people and groups, and the binding hypotheses."""

    steps: int
    """N."""
    step: float
    """Δt, s."""
    people: int
    hypotheses: int
    bodies: tuple[bool, ...]
    """Hypotheses that bind, person by person."""
    social: tuple[bool, ...]
    """The same for social spaces."""
    kind: int
    """Shape of the personal spaces."""
    groups: int
    directions: int
    walls: int

    @staticmethod
    def of(problem: LocalProblem, terms: Terms, walls: int) -> ProgramSize:
        """Structure for a problem with some half-planes."""
        weight, groups = problem.predictions.weight, problem.spaces.groups
        likeliest = np.zeros(weight.shape, dtype=bool)
        if weight.size:
            likeliest[np.arange(len(weight)), weight.argmax(axis=1)] = True

        def bind(barrier: Barrier, others: Booleans) -> tuple[bool, ...]:
            binds = likeliest | others
            return tuple((binds & _active(barrier)).ravel().tolist())

        return ProgramSize(
            steps=len(problem.reference.speeds) - 1,
            step=problem.reference.step,
            people=len(weight),
            hypotheses=weight.shape[1],
            bodies=bind(terms.bodies, weight >= 1.0),
            social=bind(terms.social_space, weight >= _SPACES_FROM),
            kind=problem.spaces.kind,
            groups=0 if groups is None else len(groups.id),
            directions=0 if groups is None else len(groups.direction),
            walls=walls,
        )


@dataclass(frozen=True, slots=True)
class Hinges:
    """max(·, 0) of the expressions of :func:`hinged`, (N, 1) each.

    In a program they are variables, with the expressions as lower bounds: IPOPT needs derivatives,
    and an optimum often lies on the edge of a hinge.
    """

    lag: Any
    """Arc length behind the reference, m."""
    wall: Any
    """Missing share of the clearance to the nearest wall; None without walls."""


def hinged(
    ca: Any, w: Terms, body: Footprint, p: dict[str, Any], poses: Any
) -> tuple[Any, list[Any]]:
    """(reference's arc length minus the robot's, missing shares of the clearance to each wall)."""
    dx, dy = poses[0, :].T - p["origin"][:, 0], poses[1, :].T - p["origin"][:, 1]
    s = p["arc"] + p["along"] * (p["tangent"][:, 0] * dx + p["tangent"][:, 1] * dy)
    wanted = w.wall_clearance.distance + p["clearance"]
    missing = [1.0 - gap[1:] / wanted for gap in _wall_gaps(ca, body, p, poses)]
    return (p["reference_arc"] - s)[1:], missing if w.wall_clearance.weight > 0.0 else []


def cost_of(
    ca: Any,
    w: Terms,
    body: Footprint,
    p: dict[str, Any],
    z: ProgramSize,
    trajectory: tuple[Any, Any],
    *,
    hinges: Hinges,
) -> Any:
    """Sum of all terms without the prices of the barriers, s; trajectory: (poses, inputs)."""
    poses, inputs = trajectory
    change = inputs - ca.horzcat(p["current_input"], inputs[:, :-1])
    effort = w.input_effort
    cost = z.step * effort.turn * ca.sumsqr(inputs[1, :])
    if isinstance(effort, InputDeviation):
        wanted = 0.0 if effort.input_cost == "printed" else p["speeds"][:-1].T
        cost += z.step * effort.speed * ca.sumsqr(inputs[0, :] - wanted)
    cost += w.input_change.speed / z.step * ca.sumsqr(change[0, :])
    cost += w.input_change.turn / z.step * ca.sumsqr(change[1, :])
    cost += _path(ca, w, p, poses, hinges.lag, z) + _tracking(ca, w, p, poses, z)
    if hinges.wall is not None:
        cost += z.step * w.wall_clearance.weight * ca.sumsqr(hinges.wall)
    # people and groups: less by the age of the prediction, and where the robot hardly moves
    standing = w.person_clearance.standing_share
    blame = ca.fmin(ca.fabs(inputs[0, :].T) / _STANDS, 1.0)
    share = p["fade"][1:] * (standing + (1.0 - standing) * blame)
    return cost + z.step * ca.dot(share, _people(ca, w, body, p, poses, z))


def _path(ca: Any, w: Terms, p: dict[str, Any], poses: Any, lag: Any, z: ProgramSize) -> Any:
    """Progress, distance from the path, and final heading, on the frozen segments of the path."""
    dx, dy = poses[0, :].T - p["origin"][:, 0], poses[1, :].T - p["origin"][:, 1]
    d = p["tangent"][:, 0] * dy - p["tangent"][:, 1] * dx
    cost = w.progress.mean / (p["max_speed"] * z.steps) * ca.sum1(lag)
    end = ca.sqrt(lag[-1] ** 2 + d[-1] ** 2 + _ROUNDED**2) - _ROUNDED
    cost += w.progress.final / p["max_speed"] * end
    cost += z.step * w.path_distance.weight * ca.sumsqr(d[1:])
    ax, ay = p["aim"][0] - poses[0, -1], p["aim"][1] - poses[1, -1]
    facing = ca.cos(poses[2, -1]) * ax + ca.sin(poses[2, -1]) * ay
    cosine = p["forward"] * facing / ca.sqrt(ax**2 + ay**2)
    return cost + w.final_heading.weight * (1.0 - cosine)


def _tracking(ca: Any, w: Terms, p: dict[str, Any], poses: Any, z: ProgramSize) -> Any:
    """Xu et al., eq. (12): squared distance and heading error from the reference's poses."""
    duration = np.full((1, z.steps), z.step)
    duration[0, -1] += w.tracking.terminal
    error = poses[:, 1:].T - p["reference"][1:, :]
    squares = w.tracking.position * (error[:, 0] ** 2 + error[:, 1] ** 2)
    return ca.mtimes(duration, squares + w.tracking.heading * error[:, 2] ** 2)


def _people(
    ca: Any, w: Terms, body: Footprint, p: dict[str, Any], poses: Any, z: ProgramSize
) -> Any:
    """Costs of people and groups at the states 1…N, (N, 1), per second."""
    total = ca.SX.zeros(z.steps)
    for q in range(z.people * z.hypotheses):
        gap, extent, _ = _seen(ca, body, p, poses, z, q)
        lacking = ca.fmax(p["margin"][:, q] - gap, 0.0)
        intrusion = ca.fmax(extent - gap, 0.0) / extent
        cost = w.person_clearance.weight * lacking**2 + w.personal_space.weight * intrusion**2
        total += p["weight"][q] * cost[1:]
    for depth in _depths(ca, body, p, poses, z):
        total += w.group_space.weight * depth[1:] ** 2
    return total


def barriers(
    ca: Any, w: Terms, body: Footprint, p: dict[str, Any], poses: Any, z: ProgramSize
) -> list[tuple[Barrier | WallBarrier, list[Any]]]:
    """(barrier, series of h over the states that share a slack) of each slack."""
    bodies: list[list[Any]] = [[] for _ in range(z.people)]
    social: list[list[Any]] = [[] for _ in range(z.people)]
    for q in range(z.people * z.hypotheses):
        gap, extent, own = _seen(ca, body, p, poses, z, q)
        if z.bodies[q]:
            bodies[q // z.hypotheses].append(gap - p["margin"][:, q])
        if z.social[q]:
            social[q // z.hypotheses].append(gap - extent - own)
    walls = [gap - p["clearance"] for gap in _wall_gaps(ca, body, p, poses)]
    grouped: list[tuple[Barrier | WallBarrier, list[Any]]] = [
        *((w.bodies, each) for each in bodies), *((w.social_space, each) for each in social)
    ]  # fmt: skip
    if _active(w.walls):
        grouped.append((w.walls, walls))  # with γ = 1 each half-plane has rows of its own
    return [(law, [ca.fmin(h, _SATURATED) for h in series]) for law, series in grouped if series]


def _active(barrier: Barrier | WallBarrier) -> bool:
    return barrier.l1 > 0.0 or barrier.l2 > 0.0


def _wall_gaps(ca: Any, body: Footprint, p: dict[str, Any], poses: Any) -> list[Any]:
    """Gap of each disc to each half-plane at each state."""
    out = []
    for ax, ay, radius in body.discs:
        cx, cy = _point(ca, poses, ax, ay)
        planes = ca.horzsplit(p["planes"]) if p["planes"].numel() else ()
        out += [plane[0] * cx + plane[1] * cy - plane[2] - radius for plane in planes]
    return out


def _depths(ca: Any, body: Footprint, p: dict[str, Any], poses: Any, z: ProgramSize) -> list[Any]:
    """Depth of a disc about the middle of the spine in the hull of each group."""
    ax, ay, bx, by, radius = body.capsule
    x, y = _point(ca, poses, 0.5 * (ax + bx), 0.5 * (ay + by))
    states, out = z.steps + 1, []
    for g in range(z.groups):
        support = p["support"][:, g * states : (g + 1) * states].T
        inner = []
        for m in range(z.directions):
            ux, uy = ca.cos(p["direction"][m]), ca.sin(p["direction"][m])
            inner.append(support[:, m] - ux * x - uy * y + radius)
        out.append(ca.fmax(functools.reduce(ca.fmin, inner), 0.0))
    return out


def _point(ca: Any, poses: Any, x: float, y: float) -> tuple[Any, Any]:
    """Position of a point of the robot at each state."""
    cos, sin = ca.cos(poses[2, :]).T, ca.sin(poses[2, :]).T
    return poses[0, :].T + cos * x - sin * y, poses[1, :].T + sin * x + cos * y


def _seen(
    ca: Any, body: Footprint, p: dict[str, Any], poses: Any, z: ProgramSize, q: int
) -> tuple[Any, Any, Any]:
    """(gap to the body, extent of the person's space, that of the robot's own) of hypothesis q."""
    x, y, heading = poses[0, :].T, poses[1, :].T, poses[2, :].T
    cos, sin = ca.cos(heading), ca.sin(heading)
    dx, dy = p["x"][:, q] - x, p["y"][:, q] - y
    qx, qy = cos * dx + sin * dy, -sin * dx + cos * dy
    ax, ay, bx, by, radius = body.capsule
    length2 = (bx - ax) ** 2 + (by - ay) ** 2
    share = ((qx - ax) * (bx - ax) + (qy - ay) * (by - ay)) / length2 if length2 > 0.0 else 0.0
    share = ca.fmax(0.0, ca.fmin(1.0, share))
    ex, ey = qx - ax - share * (bx - ax), qy - ay - share * (by - ay)
    ahead = ca.atan2(ey, ex)
    gap = ca.sqrt(ex**2 + ey**2 + _SMOOTH) - radius - p["radius"][q // z.hypotheses]
    sigmas = (p["front"][:, q], p["side"][:, q], p["rear"][:, q])
    angle = ahead + heading + np.pi - p["axis"][:, q]
    extent = _extent(ca, z.kind, sigmas, angle, p["floor"], p["scale"])
    sigmas = (p["robot"][0], p["robot"][1], p["robot"][2])
    return gap, extent, _extent(ca, z.kind, sigmas, ahead, p["robot_floor"], p["scale"])


def _extent(
    ca: Any, kind: int, sigmas: tuple[Any, Any, Any], delta: Any, floor: Any, scale: Any
) -> Any:
    """Xu et al., eq. (5), floored; the contour or as printed."""
    front, side, rear = sigmas
    sigma = front if kind == ELLIPSE else ca.if_else(ca.cos(delta) > 0.0, front, rear)
    q = ca.cos(delta) ** 2 / (2.0 * sigma**2) + ca.sin(delta) ** 2 / (2.0 * side**2)
    length = scale / q if kind == PRINTED else ca.sqrt(scale / q)
    return ca.fmax(floor, length)
