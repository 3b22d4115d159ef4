"""Cost of perception: one cloud, fifty tracks, more points, more people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.claims import Bound, measured
from cohelm.evaluation.perception.recording_view import NO_MAP, perception_of
from cohelm.evaluation.perception.tracked_film import detections
from cohelm.maps import read_floor_plan
from cohelm.messages import Observation
from cohelm.perception import PerceptionParts, Tracker, perceive
from cohelm.plotting.charts import CostPanel, draw_costs_against
from cohelm.robots import LidarMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import generator
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud
from cohelm.stopwatch import Stopwatch, Timing

PART = "speed, one core, thread CPU time"
MOST_MEDIAN, MOST_P99, MOST_TRACKING = Bound(high=12.0), Bound(high=25.0), Bound(high=0.5)
"""Median and 99th percentile of a cloud, median of a tracking update, ms."""
PICTURE = "costs.png"
TRACKS = 50
RETURNS, DEVIATION = 4, 0.05
"""Returns of each detected person; deviation of the centre, m."""
STEP = 0.1
"""Interval of frames, s."""
WARM = 5
"""Frames that are not counted: compilation, new tracks."""


def cost(parts: PerceptionParts, frames: Sequence[Observation]) -> Floats:
    """Thread CPU time of the whole pipeline for each of the frames (k,), s."""
    memory, times = None, []
    for observation in frames:
        watch = Stopwatch()
        _, memory = perceive(parts, observation, NO_MAP, memory)
        times.append(watch.elapsed())
    return np.array(times)


def tracking(frames: int = 300, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Cost of an update of fifty tracks."""
    tracker = perception_of(settings).tracker
    times, count = _track(tracker, frames)
    timing = Timing.of(times)
    said = f"{frames} updates, {count} people tracked; p99 {timing.p99:.2f} ms"
    yield measured(
        PART, f"{TRACKS} tracks, median", timing.median, unit="ms", bound=MOST_TRACKING,
        valid=count >= TRACKS, remark=said,
    )  # fmt: skip


def _track(tracker: Tracker, frames: int) -> tuple[Floats, int]:
    """Times (frames,), s, and the final number of tracked people."""
    rng = np.random.default_rng(0)
    rows, columns = np.divmod(np.arange(TRACKS), 10)
    start = np.stack([2.0 * columns, 2.0 * rows], axis=-1) - (9.0, -2.0)
    velocity = rng.uniform(-0.05, 0.05, (TRACKS, 2))
    memory, times, count = None, [], 0
    for k in range(WARM + frames):
        now = k * STEP
        truth = start + now * velocity
        where = truth + rng.normal(scale=0.03, size=truth.shape)
        found = detections(now, where, DEVIATION, returns=RETURNS)
        observation = Observation.at_rest(now)
        watch = Stopwatch()
        people, memory = tracker.track(observation, (found,), memory)
        times.append(watch.elapsed())
        count = len(people)
    return np.array(times[WARM:]), count


def cloud(frames: int = 250, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Cost of a cloud of 32 × 1024 rays, from the points to the people."""
    timing = Timing.of(cost(perception_of(settings), crowded(10, LidarMount(), frames))[WARM:])
    said = f"{timing.rounds} clouds of a hall with 10 people, from points to people and groups"
    yield measured(
        PART, "32 × 1024, median", timing.median, unit="ms", bound=MOST_MEDIAN, remark=said
    )
    yield measured(
        PART,
        "32 × 1024, p99",
        timing.p99,
        unit="ms",
        bound=MOST_P99,
        remark=f"worst {timing.maximum:.1f} ms",
    )


def costs(folder: Path, frames: int = 35, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Cost of more points and more people, with a picture."""
    parts = perception_of(settings)
    points = np.array([_cost_of(parts, 10, rays, frames) for rays in (64, 256, 512, 1024, 2048)])
    people = np.array([_cost_of(parts, many, 1024, frames) for many in (0, 5, 10, 20, 40)])
    panels = [
        CostPanel(
            "10 people", "rays of a cloud", points[:, [1, 2, 3]], MOST_MEDIAN.high, 32 * 1024.0
        ),
        CostPanel("32 × 1024 rays", "people in a hall", people[:, [0, 2, 3]]),
    ]
    draw_costs_against(panels, folder / PICTURE)
    for count, rays, median, p99 in (*points, *people):
        what = f"{rays:.0f} rays, {count:.0f} people"
        said = f"{frames} clouds; p99 {p99:.1f} ms; {PICTURE}"
        yield measured("cost", what, median, unit="ms", remark=said)


def crowded(count: int, mount: LidarMount, frames: int) -> list[Observation]:
    """Clouds of a hall with people who walk around a standing chair, 1.5 m away and farther."""
    rng = generator(0, "crowded")
    grid = read_floor_plan(floor_file("hall")).draw()[0]
    scenery, middle = StaticScene(grid=grid), np.array([7.0, 7.0])
    ring = 1.5 + 0.25 * np.sqrt(np.arange(count) * 10.0)
    start, speed = 2.4 * np.arange(count), rng.uniform(0.5, 1.3, count)
    out = []
    for k in range(WARM + frames):
        now = k * STEP
        angle = start + speed * now / ring
        bodies = replace(
            HumanBodies.standing(
                middle + ring[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
            ),
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
    """Number of people, rays, median and 99th percentile of the cost, ms."""
    mount = LidarMount(azimuths=azimuths)
    timing = Timing.of(cost(parts, crowded(count, mount, frames))[WARM:])
    return count, float(mount.rings * azimuths), timing.median, timing.p99
