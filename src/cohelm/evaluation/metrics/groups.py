"""What those had of it who walk or stand together."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.metrics.people import INTRUSION_LEVEL, widths
from cohelm.evaluation.ride import Ride

DIRECTIONS = 72
"""In which a space's extent is looked at, evenly round: a depth is too great by 0.002 at most."""


def group_space_intrusion(ride: Ride) -> float:
    """∫ max over groups of their space's depth at the drive axle's centre dt, s; NaN: no groups."""
    depth = _deepest(ride)
    return float("nan") if depth is None else float(depth.sum() * ride.step)


def group_space_intrusion_share(ride: Ride) -> float:
    """Share of time in which the drive axle is deeper than one half in some group's space.

    That is: within the convex hull of the contours of its members' Gaussians at one half. NaN where
    there are no groups.
    """
    depth = _deepest(ride)
    return float("nan") if depth is None else float((depth > INTRUSION_LEVEL).mean())


def _deepest(ride: Ride) -> Floats | None:
    """The greatest depth in any group's space, (k,), 0…1; None: there are no groups."""
    depth = None
    for members in _groups(ride):
        here = group_depth(ride, members)
        depth = here if depth is None else np.maximum(depth, here)
    return depth


def _groups(ride: Ride) -> Iterator[Booleans]:
    """Members (n,) of every group of two or more."""
    numbers = None if ride.setup is None else ride.setup.crowd.group
    if numbers is None or len(numbers) != ride.people.shape[1]:
        return
    for number in np.unique(numbers[numbers >= 0]):
        members = numbers == number
        if members.sum() > 1:
            yield members


def group_depth(ride: Ride, members: Booleans) -> Floats:
    """How deep the drive axle is in the space of some people (n,) who are a group, (k,), 0…1.

    The greatest g of which the convex hull of their Gaussians' contours at g holds the axle's
    centre; of one person the Gaussian itself, and of several nowhere less than anybody's. A contour
    at g is the one at 1/e times s = √(ln 1/g), so that s is the greatest over directions u of the
    least over members of (r − p)·u / h(u), h being how far the contour at 1/e reaches along u.

    Where fewer than two of them are there it is 0.
    """
    there = np.isfinite(ride.people[:, members, 0])
    at = np.flatnonzero(there.sum(axis=1) > 1)
    depth = np.zeros(len(ride.people))
    if not len(at):
        return depth
    angle = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    delta = ride.pose[at, None, :2] - ride.people[at][:, members, :2]
    along = delta[..., :1] * np.cos(angle) + delta[..., 1:] * np.sin(angle)
    share = along / _reach(ride, members, angle)[at]
    least = np.where(there[at][..., None], share, np.inf).min(axis=1)
    depth[at] = np.exp(-(least.max(axis=1).clip(min=0.0) ** 2))
    return depth


def _reach(ride: Ride, members: Booleans, angle: Floats) -> Floats:
    """How far the contours at 1/e reach in directions (u,), (k, m, u), m."""
    front, side, rear = (each[:, members, None] for each in widths(ride))
    cos = np.cos(angle - ride.people_heading[:, members, None])
    along = np.where(cos > 0.0, front, rear)
    reach: Floats = np.sqrt(2.0 * ((along * cos) ** 2 + side**2 * (1.0 - cos**2)))
    return reach
