"""Run the perception pipeline on a recording, frame by frame."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats, value
from cohelm.config import nearest, override
from cohelm.errors import ConfigError
from cohelm.evaluation.perception.ego_motion import EgoMotion
from cohelm.evaluation.perception.ego_pose import EgoPathSummary, EgoPoses, PoseSource
from cohelm.evaluation.perception.level import NO_FLOOR, Levellers
from cohelm.maps import DistanceField
from cohelm.messages import Observation, Sensing
from cohelm.perception import (
    PerceptionMemory,
    PerceptionParts,
    PerceptionResult,
    perceive,
)
from cohelm.recordings import Frame, Labels
from cohelm.scenarios.scenario import PARTS

DETECTION_PARTS = ("detector", "cloud_detector", "tracker", "group_detector")
"""Parts that detect people, in the order of the pipeline."""
PREDICTION_PARTS = ("predictor", "social_model")
"""Parts that predict people and compute their spaces."""
GAP = 1.0
"""Time between two frames above which a gap is reported, s."""
LASTING = 2.0
"""Duration above which a track counts as a person who stayed in view, s."""
REPEATS, REPEAT_STEP = 10, 0.1
"""Repetitions of a single frame before it is scored, and the time between them, s."""
_SENSOR_IDS = 10**6
"""Difference of the first ids of two sensors with an origin each."""
NO_MAP = DistanceField(
    distance=np.full((2, 2), 1e6, dtype=np.float32), resolution=1.0, X_MG=np.zeros(3)
)
"""Distances to walls without a map: there are none."""


@value
class PerceivedFrame:
    """One frame with its perceived people."""

    observation: Observation
    labels: Labels | None
    perceived: PerceptionResult
    source: PoseSource = PoseSource.RECORDED
    """Origin of the robot's pose."""
    ego_motion: EgoMotion | None = None
    """Trajectory so far, where it is estimated."""
    warning: str = ""
    """Assumption about the axes of its cloud."""


def parts_of(settings: Iterable[str] = (), keys: Iterable[str] = DETECTION_PARTS) -> dict[str, Any]:
    """Build the default parts of a scenario, with settings.

    Args:
        settings: ``part.parameter=value``, as of a scenario.
        keys: parts to build; settings may concern all parts of perception.

    Raises:
        ConfigError: naming the key that does not exist or does not fit.
        PluginError: if a part does not exist or does not import.
    """
    known = (*DETECTION_PARTS, *PREDICTION_PARTS)
    settings = list(settings)
    for setting in settings:
        name, _, below = setting.partition("=")[0].partition(".")
        if name.strip() not in known:
            raise ConfigError(f"no such part{nearest(name, known)}", key=setting)
        if not below:
            raise ConfigError(f"name its parameter, as {name}.use=NAME", key=setting)
    given = override({key: {"use": PARTS[key][1]} for key in known}, settings)
    return {key: plugins.build(PARTS[key][0], given[key], key=key) for key in keys}


def perception_of(settings: Iterable[str] = (), outline: Floats | None = None) -> PerceptionParts:
    """Parts of the pipeline, see :func:`parts_of`; ``outline`` (k, 2) is that of the robot, m."""
    return PerceptionParts(**parts_of(settings), outline=outline)


def perceive_frames(
    frames: Iterable[Frame],
    parts: PerceptionParts,
    walls: DistanceField = NO_MAP,
    *,
    still: bool = False,
    at_rest: bool = False,
) -> Iterator[PerceivedFrame]:
    """Run perception on each frame, in order.

    A single frame is repeated ``REPEATS`` times at ``REPEAT_STEP`` before its result counts, since
    the tracker reports no person at first sight. Poses that are not recorded are estimated from the
    readings; where consecutive readings do not match, tracking restarts. Each sensor whose place on
    the robot is unknown has its own origin, poses and people.

    Args:
        frames: frames of a recording.
        parts: parts of perception.
        walls: distances to the walls of a map.
        still: every frame is independent, as in a recording with a single one.
        at_rest: assume a robot without recorded poses at rest at (0, 0, 0).
    """
    own_way, streams = EgoPoses(at_rest=at_rest or still), dict[str, _Stream]()
    levellers = Levellers()
    for leveled, warning in map(levellers, frames):
        placed = own_way(leveled)
        frame = placed.frame
        stream = streams.setdefault(frame.unplaced, _Stream(ids=Ids(_SENSOR_IDS * len(streams))))
        parts_of_way = own_way.parts(frame.unplaced)
        if parts_of_way != stream.parts_of_way:
            stream.memory, stream.parts_of_way = None, parts_of_way
            stream.ids.start_part()
        if still:
            stream.memory = None
            for k in range(REPEATS, 0, -1):
                before = earlier(frame.observation, k * REPEAT_STEP)
                _, stream.memory = perceive(parts, before, walls, stream.memory)
        perceived, stream.memory = perceive(parts, frame.observation, walls, stream.memory)
        if warning == NO_FLOOR and perceived.sensing is Sensing.OK:
            perceived = replace(perceived, sensing=Sensing.NO_FLOOR)
        yield PerceivedFrame(
            observation=frame.observation,
            labels=frame.labels,
            perceived=stream.ids(perceived),
            source=placed.source,
            ego_motion=placed.ego_motion,
            warning=warning,
        )


@dataclass
class _Stream:
    """Tracking of the frames that share one origin."""

    ids: Ids
    memory: PerceptionMemory | None = None
    parts_of_way: int = 0


class Ids:
    """Keeps ids of separately tracked parts of a recording apart."""

    def __init__(self, first: int = 0) -> None:
        self._first = self._next = first

    def start_part(self) -> None:
        """Start a part whose ids begin at 0."""
        self._first = self._next

    def __call__(self, perceived: PerceptionResult) -> PerceptionResult:
        """Result with ids that no earlier part has."""
        people, groups = perceived.people, perceived.groups
        if self._first:
            people = replace(people, id=people.id + self._first)
            groups = replace(groups, id=groups.id + self._first)
            perceived = replace(perceived, people=people, groups=groups)
        latest = max(people.id.max(initial=-1), groups.id.max(initial=-1))
        self._next = max(self._next, int(latest) + 1)
        return perceived


def earlier(observation: Observation, seconds: float) -> Observation:
    """The readings at an earlier time, s."""
    scans = tuple(replace(each, time=each.time - seconds) for each in observation.scans)
    clouds = tuple(replace(each, time=each.time - seconds) for each in observation.clouds)
    return replace(
        observation,
        time=observation.time - seconds,
        pose_time=observation.pose_time - seconds,
        twist_time=observation.twist_time - seconds,
        scans=scans,
        clouds=clouds,
    )


def frame_record(seen: PerceivedFrame) -> Mapping[str, Any]:
    """Record of a frame in ``cohelm people --json``: time, sensing quality, pose and people.

    ``pose`` is that of the robot, x, y and heading, in the frame of the people's positions.
    """
    people, groups = seen.perceived.people, seen.perceived.groups
    return {
        "t": round(seen.observation.time, 6),
        "sensing": seen.perceived.sensing.value,
        "pose": (seen.observation.pose.round(4) + 0.0).tolist(),
        "people": [
            {
                "id": int(people.id[i]),
                **dict(zip(("x", "y", "vx", "vy"), people.mean[i].round(4).tolist(), strict=True)),
                "confidence": round(float(people.confidence[i]), 4),
                "group": int(groups.id[member]) if member >= 0 else None,
            }
            for i, member in enumerate(groups.member)
        ],
    }


class RecordingSummary:
    """Summary of a whole recording, updated frame by frame."""

    def __init__(self) -> None:
        self.frames = 0
        self.begin = math.nan
        """Time of the first frame, s."""
        self.end = math.nan
        """The latest time of any frame, s."""
        self.gaps: list[tuple[float, float]] = []
        """Intervals without a frame, s."""
        self.max_people = 0
        """Largest number of people at once."""
        self.sensing: Counter[Sensing] = Counter()
        self.groups: set[int] = set()
        """Ids."""
        self.ego_path = EgoPathSummary()
        self.warnings: dict[str, int] = {}
        """Assumptions about the axes of clouds, and the number of frames with each."""
        self._trails: dict[int, list[tuple[float, float, float]]] = {}

    def add(self, seen: PerceivedFrame) -> None:
        """Add one frame."""
        time, people = seen.observation.time, seen.perceived.people
        self.begin = self.begin if self.frames else time
        if self.frames and time - self.end > GAP:
            self.gaps.append((self.end, time))
        self.end = max(time, self.end) if self.frames else time
        self.frames += 1
        self.max_people = max(self.max_people, len(people))
        self.sensing[seen.perceived.sensing] += 1
        self.ego_path.add(seen.source, seen.ego_motion)
        if seen.warning:
            self.warnings[seen.warning] = self.warnings.get(seen.warning, 0) + 1
        self.groups |= set(seen.perceived.groups.id.tolist())
        for who, (x, y) in zip(people.id.tolist(), people.mean[:, :2].tolist(), strict=True):
            self._trails.setdefault(who, []).append((time, x, y))

    @property
    def trails(self) -> dict[int, Floats]:
        """Id → (k, 3) of (time s, x, y m)."""
        return {who: np.array(trail) for who, trail in self._trails.items()}

    def lasting(self, seconds: float = LASTING) -> list[int]:
        """Ids of tracks that last longer, s."""
        return [who for who, trail in self._trails.items() if trail[-1][0] - trail[0][0] > seconds]

    def switched_ids(self, seconds: float = 1.5, distance: float = 0.7) -> int:
        """Count probable identity switches without labels.

        A track continues another one if it begins within so many seconds (s) of the other's end,
        and within ``distance`` (m) of the other's position extrapolated from its last second.
        """
        trails = sorted(self.trails.values(), key=lambda each: float(each[0, 0]))
        return sum(_continues_another(trail, trails, seconds, distance) for trail in trails)


def _continues_another(
    trail: Floats, trails: Sequence[Floats], seconds: float, distance: float
) -> bool:
    """Check that a trail (k, 3) continues another one."""
    time, place = trail[0, 0], trail[0, 1:]
    for other in trails:
        ended = other[-1, 0]
        if other is trail or other[0, 0] >= time or not abs(time - ended) <= seconds:
            continue
        tail = other[other[:, 0] >= ended - 1.0]
        span = tail[-1, 0] - tail[0, 0]
        velocity = (tail[-1, 1:] - tail[0, 1:]) / span if span > 0.0 else np.zeros(2)
        if math.dist(place, tail[-1, 1:] + (time - ended) * velocity) <= distance:
            return True
    return False
