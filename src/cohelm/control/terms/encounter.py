"""Geometry between the robot and a predicted person, shared by all terms about people."""

from __future__ import annotations

import math

from numba import njit

from cohelm.arrays import Floats
from cohelm.control.people_table import AHEAD, ASIDE, AXIS_X, AXIS_Y, BEHIND, PeopleTable
from cohelm.control.terms.stage import Encounter, Stage
from cohelm.kernels import INNER, KERNEL, callee
from cohelm.robots.capsule import nearest_on_spine

_STEEPEST = 2.0
"""Upper bound on the slope of a space's extent, m/rad over m: the flank of a narrow space would
otherwise dominate."""


@njit(**INNER)
def encounter(
    capsule: Floats, cos: float, sin: float, dx: float, dy: float, radius: float
) -> Encounter:
    """A person of some radius at (dx, dy) from the robot, which has the heading (cos, sin)."""
    distance, ex, ey, sx, sy, inside = nearest_on_spine(capsule, cos, sin, dx, dy)
    nx, ny = cos * ex - sin * ey, sin * ex + cos * ey
    gap = distance - capsule[4] - radius
    return Encounter(gap, distance, ex, ey, nx, ny, sx, sy, inside)


@callee(INNER)
def gap_gradient(e: Encounter) -> tuple[float, float, float]:
    """∂gap/∂(x, y, θ)."""
    return -e.nx, -e.ny, e.ex * e.sy - e.ey * e.sx


@callee(INNER)
def person_extent(people: PeopleTable, state: Floats, e: Encounter) -> float:
    """l_i, the extent of a personal space towards the robot, m; Xu et al., eq. (5)."""
    cos = -(e.nx * state[AXIS_X] + e.ny * state[AXIS_Y])
    along = state[AHEAD] if cos > 0.0 else state[BEHIND]
    q = state[ASIDE] + (along - state[ASIDE]) * cos * cos
    length = 1.0 / q if people.printed else 1.0 / math.sqrt(q)
    return max(length, people.floor)


@callee(INNER)
def own_extent(people: PeopleTable, e: Encounter) -> float:
    """l, the extent of the robot's own space towards the person, m."""
    along = people.own[0] if e.ex > 0.0 else people.own[1]
    q = people.own[2] + (along - people.own[2]) * e.ex * e.ex
    length = 1.0 / q if people.printed else 1.0 / math.sqrt(q)
    return max(length, people.own_floor)


@callee(KERNEL)
def extent_gradients(
    people: PeopleTable, state: Floats, e: Encounter
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """(∂l_i/∂(x, y, θ), ∂l/∂(x, y, θ)) of the person's extent and of the robot's own."""
    cos = -(e.nx * state[AXIS_X] + e.ny * state[AXIS_Y])
    sin = e.nx * state[AXIS_Y] - e.ny * state[AXIS_X]
    along = state[AHEAD] if cos > 0.0 else state[BEHIND]
    theirs = _slope(along, state[ASIDE], cos, sin, people.printed, people.floor)
    along = people.own[0] if e.ex > 0.0 else people.own[1]
    own = _slope(along, people.own[2], e.ex, e.ey, people.printed, people.own_floor)
    # turn of the direction with the pose: with the spine where the nearest point is inside it,
    # else about its fixed end
    tx, ty, ta = 0.0, 0.0, 1.0
    if not e.inside:
        d = e.distance
        tx, ty, ta = e.ny / d, -e.nx / d, -(e.ex * e.sx + e.ey * e.sy) / d
    return (theirs * tx, theirs * ty, theirs * ta), (own * tx, own * ty, own * (ta - 1.0))


@callee(INNER)
def _slope(
    along: float, aside: float, cos: float, sin: float, printed: bool, floor: float
) -> float:
    """dl/dδ of an extent; 0 at the floor."""
    q = aside + (along - aside) * cos * cos
    dq = 2.0 * (aside - along) * sin * cos
    length = 1.0 / q if printed else 1.0 / math.sqrt(q)
    if length < floor:
        return 0.0
    return -length * length * dq if printed else -0.5 * length * length * length * dq


@callee(INNER)
def bounded(
    gradient: tuple[float, float, float],
) -> tuple[float, float, float]:
    """The gradient of a barrier, at most ``_STEEPEST`` by position."""
    gx, gy, ga = gradient
    steep = math.sqrt(gx * gx + gy * gy)
    cut = _STEEPEST / steep if steep > _STEEPEST else 1.0
    return cut * gx, cut * gy, cut * ga


@callee(INNER)
def state_encounter(people: PeopleTable, capsule: Floats, q: int, stage: Stage) -> Encounter:
    """Hypothesis q at a stage."""
    state = people.states[q, stage.k]
    dx, dy = state[0] - stage.x, state[1] - stage.y
    return encounter(capsule, stage.cos, stage.sin, dx, dy, people.radius[q])
