"""What perception costs: one cloud, fifty tracks, more points, more people."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.perception_rows import Row, row
from cohelm.evaluation.scenario import floor_file
from cohelm.evaluation.watched import detections
from cohelm.evaluation.watching import NO_MAP, perception_of
from cohelm.maps import read_floor_plan
from cohelm.messages import Observation
from cohelm.perception import PerceptionParts, Tracker, perceive
from cohelm.pictures.costs import CostPanel, draw_costs_against
from cohelm.robots import LidarMount
from cohelm.simulation import generator
from cohelm.simulation.sensors import Bodies, Scenery, scan_cloud

PART = "speed, one core, thread CPU time"
MOST_MEDIAN, MOST_P99, MOST_TRACKING = 12.0, 25.0, 0.5
"""ms."""
PICTURE = "costs.png"
TRACKS = 50
RETURNS, DEVIATION = 4, 0.05
"""Of each person detected: returns; of the centre, m."""
STEP = 0.1
"""Between two frames, s."""
WARM = 5
"""Frames that are not counted: code is compiled, tracks begin."""


def cost(parts: PerceptionParts, frames: Sequence[Observation]) -> Floats:
    """Thread CPU time of the whole pipeline for each of the frames (k,), s."""
    memory, times = None, []
    for observation in frames:
        begin = time.thread_time()
        _, memory = perceive(parts, observation, NO_MAP, memory)
        times.append(time.thread_time() - begin)
    return np.array(times)


def tracking(frames: int = 300, settings: Sequence[str] = ()) -> Iterator[Row]:
    """What an update of fifty tracks costs."""
    tracker = perception_of(settings).tracker
    times, told = _track(tracker, frames)
    said = f"{frames} updates, {told} people told; p99 {1e3 * np.percentile(times, 99):.2f} ms"
    median = 1e3 * float(np.median(times))
    yield row(
        PART, f"{TRACKS} tracks, median", median, unit="ms", most=MOST_TRACKING,
        right=told >= TRACKS, remark=said,
    )  # fmt: skip


def _track(tracker: Tracker, frames: int) -> tuple[Floats, int]:
    """Times (frames,), s, and how many were told in the end."""
    rng = np.random.default_rng(0)
    rows, columns = np.divmod(np.arange(TRACKS), 10)
    start = np.stack([2.0 * columns, 2.0 * rows], axis=-1) - (9.0, -2.0)
    velocity = rng.uniform(-0.05, 0.05, (TRACKS, 2))
    memory, times, told = None, [], 0
    for k in range(WARM + frames):
        now = k * STEP
        truth = start + now * velocity
        where = truth + rng.normal(scale=0.03, size=truth.shape)
        found = detections(now, where, DEVIATION, returns=RETURNS)
        observation = Observation.at_rest(now)
        begin = time.thread_time()
        people, memory = tracker.track(observation, (found,), memory)
        times.append(time.thread_time() - begin)
        told = len(people)
    return np.array(times[WARM:]), told


def cloud(frames: int = 250, settings: Sequence[str] = ()) -> Iterator[Row]:
    """What a cloud of 32 × 1024 rays costs, from the points to the people."""
    times = 1e3 * cost(perception_of(settings), crowded(10, LidarMount(), frames))[WARM:]
    median, p99 = np.percentile(times, [50.0, 99.0])
    said = f"{len(times)} clouds of a hall with 10 people, from points to people and groups"
    yield row(PART, "32 × 1024, median", median, unit="ms", most=MOST_MEDIAN, remark=said)
    yield row(
        PART, "32 × 1024, p99", p99, unit="ms", most=MOST_P99, remark=f"worst {times.max():.1f} ms"
    )


def costs(folder: Path, frames: int = 35, settings: Sequence[str] = ()) -> Iterator[Row]:
    """What more points and more people cost, and a picture of it."""
    parts = perception_of(settings)
    points = np.array([_cost_of(parts, 10, rays, frames) for rays in (64, 256, 512, 1024, 2048)])
    people = np.array([_cost_of(parts, many, 1024, frames) for many in (0, 5, 10, 20, 40)])
    panels = [
        CostPanel("10 people", "rays of a cloud", points[:, [1, 2, 3]], MOST_MEDIAN, 32 * 1024.0),
        CostPanel("32 × 1024 rays", "people in a hall", people[:, [0, 2, 3]]),
    ]
    draw_costs_against(panels, folder / PICTURE)
    for count, rays, median, p99 in (*points, *people):
        what = f"{rays:.0f} rays, {count:.0f} people"
        said = f"{frames} clouds; p99 {p99:.1f} ms; {PICTURE}"
        yield row("cost", what, median, unit="ms", remark=said)


def crowded(count: int, mount: LidarMount, frames: int) -> list[Observation]:
    """Clouds of a hall with people who walk round a standing chair, 1.5 m away and farther."""
    rng = generator(0, "crowded")
    grid = read_floor_plan(floor_file("hall")).draw()[0]
    scenery, middle = Scenery(grid=grid), np.array([7.0, 7.0])
    ring = 1.5 + 0.25 * np.sqrt(np.arange(count) * 10.0)
    start, speed = 2.4 * np.arange(count), rng.uniform(0.5, 1.3, count)
    out = []
    for k in range(WARM + frames):
        now = k * STEP
        angle = start + speed * now / ring
        bodies = replace(
            Bodies.standing(middle + ring[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)),
            heading=angle + np.pi / 2.0,
            walked=speed * now,
            speed=speed,
        )
        pose = np.array([*middle, 0.0])
        seen = scan_cloud(mount, scenery, bodies, pose, time=now, rng=rng)
        out.append(Observation.at_rest(now, pose=pose, clouds=(seen,)))
    return out


def _cost_of(
    parts: PerceptionParts, count: int, azimuths: int, frames: int
) -> tuple[float, float, float, float]:
    """People, rays, median and 99th percentile of the cost, ms."""
    mount = LidarMount(azimuths=azimuths)
    times = 1e3 * cost(parts, crowded(count, mount, frames))[WARM:]
    median, p99 = np.percentile(times, [50.0, 99.0])
    return count, float(mount.rings * azimuths), float(median), float(p99)
