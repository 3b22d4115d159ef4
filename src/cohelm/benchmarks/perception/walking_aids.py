"""Wheelchair users, walkers, children, seated people and trolleys before a standing scanner."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import value
from cohelm.benchmarks.claims import Bound, measured
from cohelm.evaluation.perception.recording_view import NO_MAP, perception_of
from cohelm.maps import OccupancyGrid, read_floor_plan
from cohelm.messages import Observation
from cohelm.perception import PerceptionParts, perceive
from cohelm.robots import LaserMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import generator
from cohelm.simulation.sensors import BodyKind, HumanBodies, planar_discs, sweep
from cohelm.simulation.sensors.planar_bodies import RADIUS, SPEEDS

PART = "people of many kinds, planar scanner"
MOUNT = LaserMount(beams=720, field_of_view_deg=270.0)
STEP, SECONDS = 0.1, 8.0
"""Interval and duration of a passage, s."""
LATE = 1.5
"""Time after which a person must be tracked, s."""
LEAST_TRACKED = Bound(low=0.9)
"""Share of the later frames with a person within the body's radius and 0.3 m."""
SLACK = 0.3
"""Distance of a track beyond the radius of a body that still counts, m."""
WALKING = tuple(kind for kind in BodyKind if kind is not BodyKind.SEATED)


@value
class PassageTracks:
    """Tracks during one passage."""

    tracked: float
    """Share of the frames after ``LATE`` with a track at the person."""
    ids: int
    """Tracks at the person."""
    others: float
    """Other reported people per frame."""
    groups: int
    """Frames with a group."""


def passage(kind: BodyKind, seed: int, parts: PerceptionParts) -> PassageTracks:
    """One person passes a standing chair in a hall, at 1.5 to 3.5 m, in a random direction."""
    rng, grid = generator(seed, "passage"), _hall()
    pose = np.array([7.0, 7.0, rng.uniform(-0.2, 0.2)])
    speed = min(SPEEDS.get(kind, 1.2), 1.2) * rng.uniform(0.8, 1.0)
    side, turn = rng.uniform(1.5, 3.5), rng.uniform(-0.5, 0.5)
    back = rng.choice([-1.0, 1.0])
    ahead = np.array([np.sin(turn), np.cos(turn)]) * back
    middle = pose[:2] + side * np.array([np.cos(turn), -np.sin(turn)])
    heading, memory, rows = float(np.arctan2(ahead[1], ahead[0])), None, []
    for k in range(round(SECONDS / STEP)):
        along = speed * (k * STEP - 0.5 * SECONDS) if speed else 0.0
        at = middle + np.clip(along, -4.0, 4.0) * ahead
        body = HumanBodies(
            position=at[None],
            heading=np.array([heading]),
            walked=np.array([speed * k * STEP]),
            speed=np.array([speed]),
            height=np.array([1.7]),
            radius=np.array([RADIUS[kind]]),
            kind=np.array([int(kind)]),
        )
        scan = sweep(MOUNT, grid, planar_discs(body), pose, time=k * STEP, rng=rng)
        observation = Observation.at_rest(k * STEP, pose=pose, scans=(scan,))
        seen, memory = perceive(parts, observation, NO_MAP, memory)
        apart = np.hypot(*(seen.people.mean[:, :2] - at).T)
        near = apart <= RADIUS[kind] + SLACK
        rows.append((near.any(), seen.people.id[near], (~near).sum(), len(seen.groups.id)))
    later = rows[round(LATE / STEP) :]
    return PassageTracks(
        tracked=float(np.mean([row[0] for row in later])),
        ids=len(np.unique(np.concatenate([row[1] for row in rows]))),
        others=float(np.mean([row[2] for row in rows])),
        groups=int(np.count_nonzero([row[3] for row in rows])),
    )


def walking_aids(settings: Sequence[str] = (), seeds: int = 10) -> Iterator[dict[str, Any]]:
    """Rows per outline: share of the time tracked, ids, other people reported, groups."""
    parts = perception_of(settings)
    for kind in BodyKind:
        found = [passage(kind, seed, parts) for seed in range(seeds)]
        ids, others = np.mean([f.ids for f in found]), np.mean([f.others for f in found])
        groups = sum(f.groups for f in found)
        said = f"{seeds} passages; {ids:.1f} ids, {others:.2f} others a frame, {groups} with groups"
        yield measured(
            PART,
            f"{kind.name.lower()}, share of the time tracked",
            float(np.mean([f.tracked for f in found])),
            bound=LEAST_TRACKED if kind in WALKING else None,
            remark=said + ("" if kind in WALKING else "; never moves: an obstacle"),
        )


def _hall() -> OccupancyGrid:
    return read_floor_plan(floor_file("hall")).draw()[0]
