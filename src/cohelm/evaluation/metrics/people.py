"""Effect of a ride on the people around: distances, contacts, intrusions and delays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.episode.counterfactual import Counterfactual
from cohelm.evaluation.episode.ride import Ride
from cohelm.shapes import gaussian_deviations

ENCOUNTER = 2.0
"""Distance within which a person counts as encountered, m."""
INTRUSION_LEVEL = 0.5
"""Value of a person's Gaussian, 1 at the person, above which the chair intrudes; our choice."""
ABREAST, SIDE_BY_SIDE = 1.0, 1.5
"""Largest longitudinal offset and largest gap of a companion side by side, m; our choice."""
DIRECTIONS = 72
"""Directions in which the extent of a group space is evaluated; the depth errs by ≤ 0.002."""


def encounters(ride: Ride) -> int:
    """Number of people who came within 2 m."""
    return int((ride.gap_people.min(axis=0) <= ENCOUNTER).sum())


def min_distance(ride: Ride) -> float:
    """Smallest gap to a person, clipped at 0, m; NaN without people."""
    return _finite(ride.nearest.min())


def mean_distance(ride: Ride) -> float:
    """Gap to the nearest person, clipped at 0, mean over the time with people, m; NaN without."""
    there = np.isfinite(ride.nearest)
    return float(ride.nearest[there].mean()) if there.any() else float("nan")


def collisions_person(ride: Ride) -> int:
    """Number of people touched while the chair moved."""
    return int(ride.hit_moving.any(axis=0).sum())


def collisions_wall(ride: Ride) -> int:
    """Number of times that the footprint began to touch an obstacle."""
    return int((np.diff(ride.hit_wall.astype(int), prepend=0) == 1).sum())


def standing_contacts(ride: Ride) -> int:
    """Number of people who touched the chair only while it stood; not a failure of the ride."""
    return int((ride.hit_standing.any(axis=0) & ~ride.hit_moving.any(axis=0)).sum())


def proxemics(ride: Ride, lower: float, upper: float) -> float:
    """Share of time with the nearest gap in [lower, upper), m (Hall's zones)."""
    return float(((ride.nearest >= lower) & (ride.nearest < upper)).mean())


def social_space_intrusion(ride: Ride) -> float:
    """∫ max over people of their Gaussian at the centre of the drive axle dt, s."""
    return float(_deepest_person(ride).sum() * ride.step)


def social_space_intrusion_share(ride: Ride) -> float:
    """Share of time in which a person's Gaussian at the drive axle exceeds one half."""
    return float((_deepest_person(ride) > INTRUSION_LEVEL).mean())


def group_space_intrusion(ride: Ride) -> float:
    """∫ max over groups of the depth of the drive axle in their space dt, s; NaN without groups."""
    depth = _deepest(ride)
    return float("nan") if depth is None else float(depth.sum() * ride.step)


def group_space_intrusion_share(ride: Ride) -> float:
    """Share of time in which the drive axle is deeper than one half in a group space.

    That is inside the convex hull of the members' Gaussian contours at one half. NaN without
    groups.
    """
    depth = _deepest(ride)
    return float("nan") if depth is None else float((depth > INTRUSION_LEVEL).mean())


def side_by_side_share(ride: Ride) -> float:
    """Share of time side by side with the scenario's companion; NaN without a companion.

    Side by side: at most 1 m ahead of the drive axle or behind it, with a gap of at most 1.5 m.
    """
    i = ride.scenario.companion
    if i is None or i >= ride.people.shape[1]:
        return float("nan")
    away = ride.people[:, i, :2] - ride.pose[:, :2]
    along = np.cos(ride.pose[:, 2]) * away[:, 0] + np.sin(ride.pose[:, 2]) * away[:, 1]
    beside = (np.abs(along) <= ABREAST) & (ride.gap_people[:, i] <= SIDE_BY_SIDE)
    return float(beside.mean())


def time_to_collision(ride: Ride) -> float:
    """Shortest time to a contact at constant velocities, s; NaN without one.

    The discs of the footprint and the body move straight; rotation of the chair is neglected.
    """
    cos, sin = np.cos(ride.pose[:, 2]), np.sin(ride.pose[:, 2])
    v = ride.twist[:, :2]
    velocity = np.stack([cos * v[:, 0] - sin * v[:, 1], sin * v[:, 0] + cos * v[:, 1]], axis=-1)
    closing = ride.people[:, :, 2:] - velocity[:, None]
    first = np.inf
    for x, y, radius in ride.robot.discs:
        centre = ride.pose[:, :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
        touch = radius + ride.people_radius
        times = _contact_time(ride.people[:, :, :2] - centre[:, None], closing, touch)
        first = min(first, float(times.min(initial=np.inf)))
    return _finite(first)


def pedestrian_deviation(ride: Ride, without: Counterfactual | None) -> float:
    """Mean ‖p_with − p_without‖ over reacting people and the common time, m.

    Args:
        ride: ride with the robot.
        without: the same people without it; None: no person reacts, or it is not known.
    """
    if without is None:
        return float("nan")
    k, reacting = min(len(ride.people), len(without.people)), _reacting(ride)
    apart = ride.people[:k, reacting, :2] - without.people[:k, reacting, :2]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    there = np.isfinite(distance)
    return float(distance[there].mean()) if there.any() else float("nan")


def pedestrian_delay(ride: Ride, without: Counterfactual | None) -> float:
    """Added time to the last waypoint passed in both cases, mean over reacting people, s.

    Args:
        ride: ride with the robot.
        without: the same people without it; None: no person reacts, or it is not known.

    Returns:
        NaN if no person passed a waypoint in both cases.
    """
    if without is None:
        return float("nan")
    delays, reacting = [], _reacting(ride)
    targets = zip(
        ride.people_target[:, reacting].T, without.people_target[:, reacting].T, strict=True
    )
    for one, other in targets:
        passed, passed_without = np.flatnonzero(np.diff(one)), np.flatnonzero(np.diff(other))
        last = min(len(passed), len(passed_without)) - 1
        if last >= 0:
            delays.append((passed[last] - passed_without[last]) * ride.step)
    return float(np.mean(delays)) if delays else float("nan")


def person_depth(at: Floats, people: Floats, heading: Floats) -> Floats:
    """Each person's asymmetric Gaussian at a place, (k, n), 0…1; Xu et al., eq. (5).

    exp(−d² (cos²δ/2σ² + sin²δ/2σ_s²)), σ_h = max(1/2, 2|v|), σ_s = 2σ_h/3, σ_r = σ_h/2.

    Args:
        at: (k, 2) m.
        people: (k, n, 4) x, y, m, and velocity, m/s; NaN: an absent person, whose depth is 0.
        heading: (k, n) rad.
    """
    delta = at[:, None] - people[..., :2]
    cos, sin = np.cos(heading), np.sin(heading)
    ahead = cos * delta[..., 0] + sin * delta[..., 1]
    aside = cos * delta[..., 1] - sin * delta[..., 0]
    front, side, rear = _widths(people)
    along = np.where(ahead > 0.0, front, rear)
    exponent = ahead**2 / (2.0 * along**2) + aside**2 / (2.0 * side**2)
    return np.nan_to_num(np.exp(-exponent))


def group_depth(at: Floats, people: Floats, heading: Floats) -> Floats:
    """Depth of a place in the space of a group of n people, (k,), 0…1.

    The depth is the largest g for which the convex hull of the members' Gaussian contours at g
    contains the place; for one person it is the Gaussian itself. The contour at g is the contour
    at 1/e scaled by s = √(ln 1/g). Therefore s is the maximum over directions u of the minimum over
    members of (r − p)·u / h(u), with h the extent of the contour at 1/e along u.

    It is 0 while fewer than two members are present. Arguments: see :func:`person_depth`.
    """
    there = np.isfinite(people[..., 0])
    now = np.flatnonzero(there.sum(axis=1) > 1)
    depth = np.zeros(len(people))
    if not len(now):
        return depth
    angle = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    delta = at[now, None] - people[now, :, :2]
    along = delta[..., :1] * np.cos(angle) + delta[..., 1:] * np.sin(angle)
    share = along / _extent(people[now], heading[now], angle)
    least = np.where(there[now][..., None], share, np.inf).min(axis=1)
    depth[now] = np.exp(-(least.max(axis=1).clip(min=0.0) ** 2))
    return depth


def _deepest_person(ride: Ride) -> Floats:
    """Largest depth in any personal space, (k,), 0…1."""
    depth = person_depth(ride.pose[:, :2], ride.people, ride.people_heading)
    deepest: Floats = depth.max(axis=1, initial=0.0)
    return deepest


def _deepest(ride: Ride) -> Floats | None:
    """Largest depth in any group space, (k,), 0…1; None without groups."""
    depth = None
    for members in _groups(ride):
        here = group_depth(
            ride.pose[:, :2], ride.people[:, members], ride.people_heading[:, members]
        )
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


def _widths(people: Floats) -> tuple[Floats, Floats, Floats]:
    """(σ_h, σ_s, σ_r) of each person's Gaussian, each (k, n), m."""
    return gaussian_deviations(np.hypot(people[..., 2], people[..., 3]))


def _extent(people: Floats, heading: Floats, angle: Floats) -> Floats:
    """Extent of the contours at 1/e in directions (u,), (k, n, u), m."""
    front, side, rear = (each[..., None] for each in _widths(people))
    cos = np.cos(angle - heading[..., None])
    along = np.where(cos > 0.0, front, rear)
    extent: Floats = np.sqrt(2.0 * ((along * cos) ** 2 + side**2 * (1.0 - cos**2)))
    return extent


def _contact_time(offset: Floats, velocity: Floats, touch: Floats) -> Floats:
    """First t ≥ 0 with ‖offset + t·velocity‖ = ``touch``, (k, n); +inf: never."""
    a = (velocity**2).sum(axis=-1)
    b = (offset * velocity).sum(axis=-1)
    c = (offset**2).sum(axis=-1) - touch**2
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    meets = (b < 0.0) & (b * b >= a * c) & (a > 0.0)
    time = np.where(meets, (-b - root) / np.where(a > 0.0, a, 1.0), np.inf)
    return np.where(c <= 0.0, 0.0, time)


def _reacting(ride: Ride) -> Booleans:
    """People who may react to the chair, (n,)."""
    sees = ride.people_see
    return np.ones(ride.people.shape[1], dtype=np.bool_) if sees is None else sees


def _finite(number: float) -> float:
    return float(number) if np.isfinite(number) else float("nan")
