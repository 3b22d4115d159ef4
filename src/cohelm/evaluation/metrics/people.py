"""What the people had of it."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.ride import Ride
from cohelm.evaluation.unmet import Unmet

ENCOUNTER = 2.0
"""A person who comes within this is met, m."""
INTRUSION_LEVEL = 0.5
"""A person's Gaussian, 1 at the person, above this at the chair is an intrusion; our choice."""

ABREAST, SIDE_BY_SIDE = 1.0, 1.5
"""A companion is beside the chair no farther ahead or behind than this, and at most this gap away,
m; our choice."""


def encounters(ride: Ride) -> int:
    """People who came within 2 m."""
    return int((ride.gap_people.min(axis=0) <= ENCOUNTER).sum())


def min_distance(ride: Ride) -> float:
    """Least gap to a person over the ride, clipped at 0, m; NaN where there is nobody."""
    return _finite(ride.nearest.min())


def mean_distance(ride: Ride) -> float:
    """Mean over time of the gap to the nearest person, clipped at 0, m; NaN without people.

    Over the time in which anybody is there.
    """
    there = np.isfinite(ride.nearest)
    return float(ride.nearest[there].mean()) if there.any() else float("nan")


def collisions_person(ride: Ride) -> int:
    """People touched while the chair moved."""
    return int(ride.hit_moving.any(axis=0).sum())


def collisions_wall(ride: Ride) -> int:
    """Times that the footprint came to touch what stands there."""
    return int((np.diff(ride.hit_wall.astype(int), prepend=0) == 1).sum())


def standing_contacts(ride: Ride) -> int:
    """People who touched the chair only while it stood still: counted apart, no failure."""
    return int((ride.hit_standing.any(axis=0) & ~ride.hit_moving.any(axis=0)).sum())


def proxemics(ride: Ride, nearer: float, farther: float) -> float:
    """Share of time with the nearest gap in [nearer, farther), m (Hall's zones)."""
    return float(((ride.nearest >= nearer) & (ride.nearest < farther)).mean())


def social_space_intrusion(ride: Ride) -> float:
    """∫ max over people of their Gaussian at the drive axle's centre dt, s."""
    return float(_gaussian(ride).max(axis=1, initial=0.0).sum() * ride.step)


def social_space_intrusion_share(ride: Ride) -> float:
    """Share of time in which some person's Gaussian at the drive axle exceeds one half."""
    return float((_gaussian(ride).max(axis=1, initial=0.0) > INTRUSION_LEVEL).mean())


def beside_share(ride: Ride) -> float:
    """Share of time in which the scenario's companion is beside the chair; NaN where it has none.

    Beside: at most 1 m ahead of the drive axle or behind it, with a gap of at most 1.5 m.
    """
    who = ride.scenario.companion
    if who is None or who >= ride.people.shape[1]:
        return float("nan")
    away = ride.people[:, who, :2] - ride.pose[:, :2]
    along = np.cos(ride.pose[:, 2]) * away[:, 0] + np.sin(ride.pose[:, 2]) * away[:, 1]
    beside = (np.abs(along) <= ABREAST) & (ride.gap_people[:, who] <= SIDE_BY_SIDE)
    return float(beside.mean())


def _gaussian(ride: Ride) -> Floats:
    """Each person's asymmetric Gaussian at the drive axle, (k, n), 0…1; Xu et al., eq. (5).

    exp(−d² (cos²δ/2σ² + sin²δ/2σ_s²)), σ_h = max(1/2, 2|v|), σ_s = 2σ_h/3, σ_r = σ_h/2.
    """
    delta = ride.pose[:, None, :2] - ride.people[:, :, :2]
    cos, sin = np.cos(ride.people_heading), np.sin(ride.people_heading)
    ahead = cos * delta[..., 0] + sin * delta[..., 1]
    aside = cos * delta[..., 1] - sin * delta[..., 0]
    front, side, rear = widths(ride)
    along = np.where(ahead > 0.0, front, rear)
    exponent = ahead**2 / (2.0 * along**2) + aside**2 / (2.0 * side**2)
    return np.nan_to_num(np.exp(-exponent))  # NaN: a person who is not there


def widths(ride: Ride) -> tuple[Floats, Floats, Floats]:
    """(σ_h, σ_s, σ_r) of each person's Gaussian, each (k, n), m."""
    front = np.maximum(0.5, 2.0 * np.hypot(ride.people[..., 2], ride.people[..., 3]))
    return front, 2.0 * front / 3.0, front / 2.0


def time_to_collision(ride: Ride) -> float:
    """Least time to a contact if both went on with the velocities they have, s; NaN: never one.

    The footprint's discs and the body's disc move straight; the chair's turning is left out.
    """
    cos, sin = np.cos(ride.pose[:, 2]), np.sin(ride.pose[:, 2])
    v = ride.twist[:, :2]
    velocity = np.stack([cos * v[:, 0] - sin * v[:, 1], sin * v[:, 0] + cos * v[:, 1]], axis=-1)
    closing = ride.people[:, :, 2:] - velocity[:, None]
    first = np.inf
    for x, y, radius in ride.robot.discs:
        centre = ride.pose[:, :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
        reach = radius + ride.people_radius
        times = _contact_time(ride.people[:, :, :2] - centre[:, None], closing, reach)
        first = min(first, float(times.min(initial=np.inf)))
    return _finite(first)


def _contact_time(offset: Floats, velocity: Floats, reach: Floats) -> Floats:
    """When ‖offset + t·velocity‖ first equals ``reach``, (k, n), t ≥ 0; +inf: never."""
    a = (velocity**2).sum(axis=-1)
    b = (offset * velocity).sum(axis=-1)
    c = (offset**2).sum(axis=-1) - reach**2
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    meets = (b < 0.0) & (b * b >= a * c) & (a > 0.0)
    time = np.where(meets, (-b - root) / np.where(a > 0.0, a, 1.0), np.inf)
    return np.where(c <= 0.0, 0.0, time)


def pedestrian_deviation(ride: Ride, twin: Unmet | None) -> float:
    """Mean ‖p_with − p_without‖ over those who may react to the chair and the common time, m.

    Args:
        ride: with the robot.
        twin: the same people without it; None: nobody reacts, and nothing can be said.
    """
    if twin is None:
        return float("nan")
    k, who = min(len(ride.people), len(twin.people)), _reacting(ride)
    apart = ride.people[:k, who, :2] - twin.people[:k, who, :2]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    there = np.isfinite(distance)
    return float(distance[there].mean()) if there.any() else float("nan")


def pedestrian_delay(ride: Ride, twin: Unmet | None) -> float:
    """Added time to the last way-point passed in both, mean over those who may react, s.

    Args:
        ride: with the robot.
        twin: the same people without it; None: nobody reacts, and nothing can be said.

    Returns:
        NaN where nobody passed a way-point in both.
    """
    if twin is None:
        return float("nan")
    delays, who = [], _reacting(ride)
    for one, other in zip(ride.people_target[:, who].T, twin.people_target[:, who].T, strict=True):
        passed, passed_twin = np.flatnonzero(np.diff(one)), np.flatnonzero(np.diff(other))
        last = min(len(passed), len(passed_twin)) - 1
        if last >= 0:
            delays.append((passed[last] - passed_twin[last]) * ride.step)
    return float(np.mean(delays)) if delays else float("nan")


def _reacting(ride: Ride) -> Booleans:
    """Who may react to the chair, (n,)."""
    sees = ride.people_see
    return np.ones(ride.people.shape[1], dtype=np.bool_) if sees is None else sees


def _finite(number: float) -> float:
    return float(number) if np.isfinite(number) else float("nan")
