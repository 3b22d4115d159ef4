"""Recorded people near a golf cart, and the same encounters with simulated people.

The recordings are VCI-CITR (Yang et al. 2019, arXiv 1902.00487): eight people each meet a cart from
in front, from behind or across. Simulated people have the recorded starts, speeds and ways, and the
cart drives as recorded. Only people whom the recorded cart comes near are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import measured, skipped
from cohelm.errors import PluginError
from cohelm.geometry import transform
from cohelm.maps import FREE, OccupancyGrid
from cohelm.recordings.outside_data import outside_file
from cohelm.simulation import Crowd, CrowdScene

PART = "gap between people and a cart"
KINDS = {
    "front": "front_interaction",
    "back": "back_interaction",
    "across": "unidirection_normal",
    "across, two flows": "bidirection_normal",
    "across, cart yields": "unidirection_yeild",
}
"""Kind of encounter → beginning of its files, as the data set spells it."""
MODELS: Mapping[str, Mapping[str, Any]] = {
    "orca": {"use": "orca"},
    "orca, outline": {"use": "orca", "robot_outline": True},
    "social_force": {"use": "social_force"},
    "jupedsim, collision_free_speed": {"use": "jupedsim"},
    "jupedsim, anticipation_velocity": {"use": "jupedsim", "model": "anticipation_velocity"},
}
STEP = 1.0 / 30.0
"""Time between two frames, s."""
CART = 0.5 * np.array([[2.4, 1.2], [-2.4, 1.2], [-2.4, -1.2], [2.4, -1.2]])
"""Outline of the cart, m (assumed: a two-seated golf cart)."""
BODY, MARGIN = 0.25, 10.0
"""Radius of people, and free floor around all of them, m (assumed)."""
NEAR = 5.0
"""Distance from the cart within which people are compared, m."""
BEYOND = 3.0
"""Distance by which simulated people aim beyond the recorded end, m."""
HELD_OUT = slice(1, None, 2)
"""Recordings of a kind with even numbers, on which no parameter of ``orca`` was chosen."""


class Recording(NamedTuple):
    """Eight people and a cart in f frames."""

    people: Floats
    """(f, n, 2) positions, m."""
    cart: Floats
    """(f, 4) x, y, heading, speed; m, rad, m/s."""


class Manners(NamedTuple):
    """Behaviour of n people near the cart."""

    gap: Floats
    """(n,) smallest distance between body and cart, m."""
    slowing: Floats
    """(n,) largest loss of speed near the cart, as a share of the median speed."""
    side_step: Floats
    """(n,) largest distance near the cart from the line between start and end, m."""
    ahead: Floats
    """(n,) 1: crosses the cart's line in front of it, 0: behind, NaN: not at all."""


def cart_encounters() -> Iterator[dict[str, Any]]:
    """Rows of every kind of encounter: recorded people, then every model."""
    folder = outside_file("citr")
    if folder is None:
        yield skipped(PART, "encounters", missing_data("citr"))
        return
    for kind, prefix in KINDS.items():
        recordings = [_read(file) for file in sorted(folder.glob(f"{prefix}*_ped_*.csv"))]
        recorded = [manners(each.people, each.cart) for each in recordings]
        near = [each.gap < NEAR for each in recorded]
        yield _row(kind, "recorded", recorded, near)
        yield _row(kind, "recorded, held out", recorded[HELD_OUT], near[HELD_OUT])
        for name, spec in MODELS.items():
            try:
                model = plugins.build("pedestrian_models", spec)
            except PluginError as error:
                yield skipped(f"{PART}, {kind}", name, str(error))
                continue
            walked = [manners(simulated(model, each), each.cart) for each in recordings]
            yield _row(kind, name, walked, near)
            if name == "orca":
                yield _row(kind, "orca, held out", walked[HELD_OUT], near[HELD_OUT])


def simulated(model: Any, recording: Recording) -> Floats:
    """Positions (f, n, 2) of people of a model, who meet the recorded cart."""
    people, cart = recording
    n, low = people.shape[1], people.reshape(-1, 2).min(axis=0) - MARGIN
    cells = np.ceil(people.reshape(-1, 2).max(axis=0) + MARGIN - low).astype(int)
    grid = OccupancyGrid(
        data=np.full(cells[::-1], FREE, dtype=np.int8), resolution=1.0, X_MG=np.array([*low, 0.0])
    )
    velocity = (people[15] - people[0]) / (15 * STEP)
    way = people[-1] - people[0]
    goal = people[-1] + BEYOND * way / np.hypot(*way.T)[:, None]
    crowd = Crowd(
        position=people[0],
        velocity=velocity,
        heading=np.arctan2(velocity[:, 1], velocity[:, 0]),
        radius=np.full(n, BODY),
        preferred_speed=np.median(_speeds(people), axis=0),
        waypoints=goal[:, None],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=np.bool_),
        sees_robot=np.ones(n, dtype=np.bool_),
    )
    rng, out = np.random.default_rng(0), [crowd.position]
    for k, (x, y, heading, speed) in enumerate(cart[:-1]):
        scene = CrowdScene(
            grid=grid,
            robot_position=np.array([x, y]),
            robot_velocity=speed * np.array([np.cos(heading), np.sin(heading)]),
            robot_radius=float(np.hypot(*CART[0])),
            time=k * STEP,
            robot_heading=float(heading),
            robot_outline=transform([x, y, heading], CART),
        )
        crowd = model.step(crowd, scene, STEP, rng)
        out.append(crowd.position)
    return np.array(out)


def manners(people: Floats, cart: Floats) -> Manners:
    """Measure people (f, n, 2) near a cart (f, 4)."""
    offset, heading = people - cart[:, None, :2], cart[:, None, 2]
    along = offset[..., 0] * np.cos(heading) + offset[..., 1] * np.sin(heading)
    across = offset[..., 1] * np.cos(heading) - offset[..., 0] * np.sin(heading)
    outside = np.maximum(np.abs(np.stack([along, across], -1)) - CART[0], 0.0)
    gap = np.hypot(*outside.transpose(2, 0, 1)) - BODY
    watched = gap < NEAR
    speed, way = _speeds(people), people[-1] - people[0]
    way = way / np.hypot(*way.T)[:, None]
    from_start = people - people[0]
    aside = np.abs(from_start[..., 0] * way[:, 1] - from_start[..., 1] * way[:, 0])
    lowest = np.where(watched, speed, np.inf).min(axis=0)
    usual = np.median(speed, axis=0)
    crosses = (across[1:] > 0.0) != (across[:-1] > 0.0)
    first = crosses.argmax(axis=0), np.arange(people.shape[1])
    return Manners(
        gap=gap.min(axis=0),
        slowing=1.0 - np.minimum(lowest / usual, 1.0),
        side_step=np.where(watched, aside, 0.0).max(axis=0),
        ahead=np.where(crosses.any(axis=0), along[first] > 0.0, np.nan),
    )


def _speeds(people: Floats) -> Floats:
    """Speeds (f, n) over half a second around each frame, m/s."""
    frame = np.arange(len(people))
    before, after = np.maximum(frame - 8, 0), np.minimum(frame + 8, len(people) - 1)
    moved = np.hypot(*(people[after] - people[before]).transpose(2, 0, 1))
    return np.asarray(moved / (STEP * (after - before))[:, None])


def _read(file: Path) -> Recording:
    """Recording of people, and of the cart in the file beside theirs."""
    cart = np.loadtxt(file.with_name(file.name.replace("_ped_", "_veh_")), delimiter=",",
                      skiprows=1, usecols=(1, 3, 4, 5, 6))  # fmt: skip
    rows = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(0, 1, 3, 4))
    tracks = [rows[rows[:, 0] == who, 2:] for who in np.unique(rows[:, 0])]
    return Recording(np.stack(tracks, axis=1), cart[: len(tracks[0]), 1:])


def _row(kind: str, name: str, found: list[Manners], near: list[Any]) -> dict[str, Any]:
    """Median of those near, with the other measures as the remark."""
    gap, slowing, side, ahead = (
        np.concatenate([values[which] for values, which in zip(each, near, strict=True)])
        for each in zip(*found, strict=True)
    )
    crossed = ahead[np.isfinite(ahead)]
    remark = (
        f"median of {len(gap)} people; least {gap.min():.2f} m; "
        f"slow down by {np.median(slowing):.0%}; {np.median(side):.2f} m aside; "
        f"{int(crossed.sum())} of {len(crossed)} cross ahead of it"
    )
    return measured(f"{PART}, {kind}", name, float(np.median(gap)), unit="m", remark=remark)
