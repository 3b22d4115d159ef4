"""The costs and barriers of the oracle, from the equations, in CasADi's symbols.

States are columns: poses (3, N+1), inputs (2, N). ``p`` are the symbols of ``oracle``.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.control import LocalProblem, OptimalControl
from cohelm.control.terms import (
    GroupBarrier,
    InputEffort,
    InputLimits,
    PathProgress,
    PersonBarrier,
    SeatComfort,
    SmoothInput,
    SocialSpaceBarrier,
    TrackReference,
    WallBarrier,
)
from cohelm.robots import Robot
from cohelm.shapes import PRINTED

_SMOOTH = 1e-6


@dataclass(frozen=True, slots=True)
class Footprint:
    """``Robot.capsule`` and ``Robot.discs`` as a key."""

    capsule: tuple[float, ...]
    discs: tuple[tuple[float, float, float], ...]

    @staticmethod
    def of(robot: Robot) -> Footprint:
        """Footprint of a robot."""
        return Footprint(tuple(robot.capsule.tolist()), tuple(map(tuple, robot.discs.tolist())))


_POINT = Footprint((0.0,) * 5, ())
"""Robot of eq. (8) as printed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """Parameters of cost terms and constraints; None: absent."""

    step: float
    """Δt, s."""
    track_reference: TrackReference.Parameters | None = None
    input_effort: InputEffort.Parameters | None = None
    smooth_input: SmoothInput.Parameters | None = None
    comfort: SeatComfort.Parameters | None = None
    progress: PathProgress.Parameters | None = None
    input_limits: InputLimits.Parameters
    wall_clearance: WallBarrier.Parameters | None = None
    bodies: PersonBarrier.Parameters | None = None
    social_space: SocialSpaceBarrier.Parameters | None = None
    group_space: GroupBarrier.Parameters | None = None

    @staticmethod
    def of(control: OptimalControl, step: float) -> Terms:
        """Terms of a solver.

        Raises:
            TypeError: if it has a term that the oracle does not know.
        """
        parts: list[Any] = [*control.costs, *control.constraints]
        return Terms(step=step, **{part.name: part.parameters for part in parts})


@dataclass(frozen=True, slots=True)
class ProgramSize:
    """Structure of a program: numbers of people and groups, and the binding hypotheses."""

    people: int
    hypotheses: int
    bodies: tuple[bool, ...]
    """Hypotheses that bind, person by person; so is the next."""
    social: tuple[bool, ...]
    kind: int
    """Shape of the personal spaces."""
    groups: int
    directions: int

    @staticmethod
    def of(problem: LocalProblem, w: Terms) -> ProgramSize:
        """Structure for a problem."""
        weight, groups = problem.predictions.weight, problem.spaces.groups
        likeliest = np.zeros(weight.shape, dtype=bool)
        if weight.size:
            likeliest[np.arange(len(weight)), weight.argmax(axis=1)] = True

        def bind(
            law: PersonBarrier.Parameters | SocialSpaceBarrier.Parameters | None,
        ) -> tuple[bool, ...]:
            binds = np.zeros(weight.shape, dtype=bool)
            if law is not None:
                binds = likeliest | (weight >= law.min_probability)
            return tuple(binds.ravel().tolist())

        return ProgramSize(
            people=len(weight),
            hypotheses=weight.shape[1],
            bodies=bind(w.bodies),
            social=bind(w.social_space),
            kind=problem.spaces.kind,
            groups=0 if groups is None else len(groups.id),
            directions=0 if groups is None else len(groups.direction),
        )


def cost_of(ca: Any, w: Terms, p: dict[str, Any], poses: Any, inputs: Any) -> Any:
    """Xu et al., eq. (12), and the weights on changes, comfort and pace; ½ of every square."""
    change = inputs - ca.horzcat(p["current_input"], inputs[:, :-1])
    cost = 0.0
    if w.track_reference is not None:
        cost += _tracking(ca, w.step, w.track_reference, p, poses)
    if w.input_effort is not None:
        printed = w.input_effort.input_cost == "printed"
        wanted = 0.0 if printed else p["speeds"][:-1].T
        cost += 0.5 * w.step * w.input_effort.speed * ca.sumsqr(inputs[0, :] - wanted)
        cost += 0.5 * w.step * w.input_effort.turn * ca.sumsqr(inputs[1, :])
    if w.smooth_input is not None:
        cost += 0.5 / w.step * w.smooth_input.speed * ca.sumsqr(change[0, :])
        cost += 0.5 / w.step * w.smooth_input.turn * ca.sumsqr(change[1, :])
    if w.comfort is not None:
        cost += _comfort(ca, w.step, w.comfort, inputs, change)
    if w.progress is not None:
        cost += _progress(ca, w.step, w.progress, p, poses)
    return cost


def _tracking(
    ca: Any, step: float, law: TrackReference.Parameters, p: dict[str, Any], poses: Any
) -> Any:
    """Cost of the errors along and across the reference, and of the heading."""
    n = poses.shape[1] - 1
    duration = np.full((1, n), step)
    duration[0, -1] += law.terminal
    error = poses[:, 1:].T - p["reference"][1:, :]
    cos, sin = ca.cos(p["reference"][1:, 2]), ca.sin(p["reference"][1:, 2])
    along = cos * error[:, 0] + sin * error[:, 1]
    across = cos * error[:, 1] - sin * error[:, 0]
    squares = law.position * (law.along * along**2 + across**2) + law.heading * error[:, 2] ** 2
    return 0.5 * ca.mtimes(duration, squares)


def _comfort(ca: Any, step: float, law: SeatComfort.Parameters, inputs: Any, change: Any) -> Any:
    """Cost of the acceleration of the axle (v̇, ω v), and of its change."""
    felt = ca.vertcat(change[0, :] / step, inputs[0, :] * inputs[1, :])
    jerk = (felt[:, 1:] - felt[:, :-1]) / step
    return 0.5 * step * (law.acceleration * ca.sumsqr(felt) + law.jerk * ca.sumsqr(jerk))


def _progress(
    ca: Any, step: float, law: PathProgress.Parameters, p: dict[str, Any], poses: Any
) -> Any:
    """Cost of the speed along the reference, minus the reference's own."""
    behind = poses[:2, :].T - p["reference"][:, :2]
    heading = p["reference"][:-1, 2]
    gained = (behind[1:, :] - behind[:-1, :]) / step
    pace = gained[:, 0] * ca.cos(heading) + gained[:, 1] * ca.sin(heading)
    return 0.5 * step * law.pace * ca.sumsqr(pace)


def barriers(
    ca: Any, w: Terms, body: Footprint, p: dict[str, Any], poses: Any, crowd: ProgramSize
) -> list[tuple[Any, list[list[Any]]]]:
    """(law, for each slack the series of h over the states that share it)."""
    bodies: list[list[Any]] = [[] for _ in range(crowd.people)]
    social: list[list[Any]] = [[] for _ in range(crowd.people)]
    age = np.arange(poses.shape[1]) * w.step
    for q in range(crowd.people * crowd.hypotheses):
        i = q // crowd.hypotheses
        d, away, ahead = _seen(ca, body, poses, p["x"][:, q], p["y"][:, q])
        gap = d - body.capsule[4] - p["radius"][i]
        b, s, aged = w.bodies, w.social_space, p["walks"][q] * age
        if b is not None and crowd.bodies[q]:
            margin = b.margin + b.growth * aged + b.deviations * p["deviation"][:, q]
            bodies[i].append(gap - ca.fmin(margin, b.max_margin))
        if s is not None and crowd.social[q]:
            margin = s.growth * aged + s.deviations * p["deviation"][:, q]
            if s.distance == "printed":  # between the centres
                gap, away, ahead = _seen(ca, _POINT, poses, p["x"][:, q], p["y"][:, q])
            sigmas = (p["front"][:, q], p["side"][:, q], p["rear"][:, q])
            own = (p["robot"][0], p["robot"][1], p["robot"][2])
            theirs = _reach(ca, crowd.kind, sigmas, away - p["axis"][:, q], p["floor"], p["scale"])
            mine = _reach(ca, crowd.kind, own, ahead, p["robot_floor"], p["scale"])
            social[i].append(gap - ca.fmin(margin, s.max_growth) - theirs - mine)
    walls = [[h] for h in _walls(ca, body, p, poses)]
    groups = [[h] for h in _groups(ca, body, p, poses, crowd)]
    laws = (
        (w.wall_clearance, walls),
        (w.bodies, bodies),
        (w.social_space, social),
        (w.group_space, groups),
    )
    return [(law, series) for law, series in laws if law is not None]


def _walls(ca: Any, body: Footprint, p: dict[str, Any], poses: Any) -> list[Any]:
    """The barrier of each disc against the nearest half-plane."""
    planes = ca.horzsplit(p["planes"])
    out = []
    for ax, ay, radius in body.discs if planes else ():
        cx, cy = _point(ca, poses, ax, ay)
        gaps = [plane[0] * cx + plane[1] * cy - plane[2] for plane in planes]
        out.append(functools.reduce(ca.fmin, gaps) - radius - p["clearance"])
    return out


def _groups(
    ca: Any, body: Footprint, p: dict[str, Any], poses: Any, crowd: ProgramSize
) -> list[Any]:
    """The barrier of each group: the widest gap between its hull and the capsule along a normal."""
    ax, ay = _point(ca, poses, body.capsule[0], body.capsule[1])
    bx, by = _point(ca, poses, body.capsule[2], body.capsule[3])
    states, out = poses.shape[1], []
    for g in range(crowd.groups):
        support = p["support"][:, g * states : (g + 1) * states].T
        gaps = []
        for m in range(crowd.directions):
            ux, uy = ca.cos(p["direction"][m]), ca.sin(p["direction"][m])
            nearer = ca.fmin(ux * ax + uy * ay, ux * bx + uy * by)
            gaps.append(nearer - support[:, m] - body.capsule[4])
        out.append(functools.reduce(ca.fmax, gaps))
    return out


def _point(ca: Any, poses: Any, x: float, y: float) -> tuple[Any, Any]:
    """Position of a point of the robot at each state."""
    cos, sin = ca.cos(poses[2, :]).T, ca.sin(poses[2, :]).T
    return poses[0, :].T + cos * x - sin * y, poses[1, :].T + sin * x + cos * y


def _seen(ca: Any, body: Footprint, poses: Any, px: Any, py: Any) -> tuple[Any, Any, Any]:
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
