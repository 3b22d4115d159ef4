"""Hypothesis strategies for the values that flow; needs hypothesis (the extra ``test``)."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from cohelm.messages import People, Reference, RiderCommand, Scan
from cohelm.testing.scenes import local_problem, straight_reference, walkers


def coordinates(reach: float = 50.0) -> st.SearchStrategy[float]:
    """A map coordinate within ±``reach`` m."""
    return _floats(-reach, reach)


def angles() -> st.SearchStrategy[float]:
    """An angle in [−π, π], rad."""
    return _floats(-np.pi, np.pi)


def points(reach: float = 50.0) -> st.SearchStrategy[Floats]:
    """(x, y), m."""
    return st.tuples(coordinates(reach), coordinates(reach)).map(np.array)


def poses(reach: float = 50.0) -> st.SearchStrategy[Floats]:
    """(x, y, θ), m and rad."""
    return st.tuples(coordinates(reach), coordinates(reach), angles()).map(np.array)


def inputs(steps: int = 12, *, speed: float = 1.2, turn: float = 1.2) -> st.SearchStrategy[Floats]:
    """(steps, 2) of (v, ω) for a unicycle, within ±``speed`` and ±``turn``."""
    row = st.tuples(_floats(-speed, speed), _floats(-turn, turn))
    return st.lists(row, min_size=steps, max_size=steps).map(np.array)


@st.composite
def polygons(draw: st.DrawFn, *, corners: int = 8) -> Floats:
    """A simple polygon about the origin, counter-clockwise, 3 … ``corners`` corners (k, 2), m.

    Star-shaped: one corner in each of k equal sectors, so that it always contains the origin.
    """
    k = draw(st.integers(3, corners))
    share = draw(st.lists(_floats(0.3, 0.7), min_size=k, max_size=k))
    radius = np.array(draw(st.lists(_floats(0.3, 3.0), min_size=k, max_size=k)))
    angle = 2.0 * np.pi * (np.arange(k) + np.array(share)) / k
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


@st.composite
def grids(draw: st.DrawFn, *, side: int = 24) -> OccupancyGrid:
    """Up to ``side`` × ``side`` cells, free, occupied or unknown, at any position and angle."""
    shape = (draw(st.integers(1, side)), draw(st.integers(1, side)))
    cells = st.sampled_from([FREE, FREE, FREE, OCCUPIED, UNKNOWN])
    data = draw(hnp.arrays(np.int8, shape, elements=cells, fill=st.just(FREE)))
    return OccupancyGrid(data=data, resolution=draw(_floats(0.02, 0.5)), X_MG=draw(poses()))


@st.composite
def people(draw: st.DrawFn, *, most: int = 8, reach: float = 8.0) -> People:
    """0 … ``most`` people about the origin, at up to 2 m/s; some stand, with no heading."""
    row = st.tuples(
        coordinates(reach),
        coordinates(reach),
        st.just(0.0) | _floats(-1.4, 1.4),
        st.just(0.0) | _floats(-1.4, 1.4),
    )
    states = draw(st.lists(row, max_size=most))
    return walkers(np.array(states).reshape(-1, 4))


@st.composite
def scans(draw: st.DrawFn, *, beams: int = 90) -> Scan:
    """Any sweep: echoes, beams that meet nothing (+inf) and dropouts (NaN)."""
    count = draw(st.integers(1, beams))
    echo = _floats(0.05, 10.0) | st.just(float("inf")) | st.just(float("nan"))
    ranges = draw(st.lists(echo, min_size=count, max_size=count))
    return Scan(
        time=draw(_floats(0.0, 100.0)),
        mount=draw(poses(0.5)),
        angle_min=-np.pi,
        angle_increment=2.0 * np.pi / count,
        range_max=10.0,
        ranges=np.array(ranges),
    )


def rider_commands(time: float = 0.0) -> st.SearchStrategy[RiderCommand]:
    """Any deflection of a device that is alive at ``time``."""
    return st.tuples(_floats(-1.0, 1.0), _floats(-1.0, 1.0)).map(
        lambda stick: RiderCommand(heartbeat=time, deflection=np.array(stick))
    )


@st.composite
def references(draw: st.DrawFn, *, steps: int = 25, step: float = 0.1) -> Reference:
    """Straight on from any pose, at any speed up to 1.2 m/s."""
    return straight_reference(draw(poses()), draw(_floats(0.0, 1.2)), steps, step)


@st.composite
def local_problems(draw: st.DrawFn, *, steps: int = 25, step: float = 0.1) -> LocalProblem:
    """A chair on an open floor at up to 1 m/s, among up to eight people, some of them touching."""
    return local_problem(
        steps=steps,
        step=step,
        people=draw(people()),
        speed=draw(_floats(0.0, 1.0)),
        wanted=draw(_floats(0.0, 1.0)),
    )


def _floats(low: float, high: float) -> st.SearchStrategy[Any]:
    """Ordinary floats; no subnormals, whose only effect is on tests of rounding."""
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)
