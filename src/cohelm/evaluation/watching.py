"""A recording seen through the pipeline of perception, frame by frame."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats, value
from cohelm.config import nearest, override
from cohelm.errors import ConfigError
from cohelm.evaluation.own_way import OwnWay, Travelled, Whence
from cohelm.evaluation.scenario import PARTS
from cohelm.maps import DistanceField
from cohelm.messages import Observation, Sensing
from cohelm.perception import Perceived, PerceptionParts, Way, perceive
from cohelm.recordings import Frame, Labels

SEEING = ("detector", "cloud_detector", "tracker", "group_detector")
"""The parts that find people, in the order in which they work."""
SPACING = ("predictor", "social_model")
"""The parts that give them their space."""
HOLE = 1.0
"""A longer time between two frames is told, s."""
LASTING = 2.0
"""A track that lives longer counts as one of a person who stayed in view, s."""
HELD, BEAT = 10, 0.1
"""How often a still picture is looked at before, and the time between, s."""
NO_MAP = DistanceField(
    distance=np.full((2, 2), 1e6, dtype=np.float32), resolution=1.0, X_MG=np.zeros(3)
)
"""The distances to walls where no map is known: there are none."""


@value
class Seen:
    """One frame, and who was found in it."""

    observation: Observation
    labels: Labels | None
    perceived: Perceived
    whence: Whence = Whence.TOLD
    """How it is known where the robot was."""
    way: Way | None = None
    """Its way so far, where that was found."""


def parts_of(settings: Iterable[str] = (), keys: Iterable[str] = SEEING) -> dict[str, Any]:
    """The parts called ``keys``, those that a scenario has by default, with settings put in.

    Args:
        settings: ``part.parameter=value``, as of a scenario.
        keys: which parts to build; a setting may be about any of those that see or give space.

    Raises:
        ConfigError: naming the key that does not exist or does not fit.
        PluginError: if a part does not exist or does not import.
    """
    known = (*SEEING, *SPACING)
    settings = list(settings)
    for setting in settings:
        name, _, below = setting.partition("=")[0].partition(".")
        if name.strip() not in known:
            raise ConfigError(f"no such part{nearest(name, known)}", key=setting)
        if not below:
            raise ConfigError(f"name its parameter, as {name}.use=NAME", key=setting)
    given = override({key: {"use": PARTS[key][1]} for key in known}, settings)
    return {key: plugins.build(PARTS[key][0], given[key], key=key) for key in keys}


def perception_of(settings: Iterable[str] = ()) -> PerceptionParts:
    """The pipeline's parts, see :func:`parts_of`."""
    return PerceptionParts(**parts_of(settings))


def watch(
    frames: Iterable[Frame],
    parts: PerceptionParts,
    walls: DistanceField = NO_MAP,
    *,
    still: bool = False,
    at_rest: bool = False,
) -> Iterator[Seen]:
    """What the parts make of each frame, in the order of the frames.

    A still picture is shown to the parts ``HELD`` times, a ``BEAT`` apart, before it is told what
    they make of it: nobody is told at first sight. Where the recording does not say where the robot
    was, that is found from its readings; where they do not fit each other, all people begin anew.

    Args:
        frames: of a recording.
        parts: that do the work.
        walls: distances to what a static map has.
        still: whether each frame is a picture of its own, as a recording that has one only.
        at_rest: take a robot of which the recording says nothing as at rest at (0, 0, 0).
    """
    memory, own_way, parts_of_way, ids = None, OwnWay(at_rest=at_rest or still), 0, Ids()
    for placed in map(own_way, frames):
        frame = placed.frame
        if own_way.parts != parts_of_way:
            memory, parts_of_way = None, own_way.parts
            ids.anew()
        if still:
            memory = None
            for k in range(HELD, 0, -1):
                before = earlier(frame.observation, k * BEAT)
                _, memory = perceive(parts, before, walls, memory)
        perceived, memory = perceive(parts, frame.observation, walls, memory)
        yield Seen(
            observation=frame.observation,
            labels=frame.labels,
            perceived=ids(perceived),
            whence=placed.whence,
            way=placed.way,
        )


class Ids:
    """Keeps ids apart between parts of a recording that have nothing to do with each other."""

    def __init__(self) -> None:
        self._first = self._next = 0

    def anew(self) -> None:
        """The ids of what follows begin at 0 again."""
        self._first = self._next

    def __call__(self, perceived: Perceived) -> Perceived:
        """The same with ids that were not told in an earlier part."""
        people, groups = perceived.people, perceived.groups
        if self._first:
            people = replace(people, id=people.id + self._first)
            groups = replace(groups, id=groups.id + self._first)
            perceived = replace(perceived, people=people, groups=groups)
        latest = max(people.id.max(initial=-1), groups.id.max(initial=-1))
        self._next = max(self._next, int(latest) + 1)
        return perceived


def earlier(observation: Observation, seconds: float) -> Observation:
    """The same readings, taken so much earlier, s."""
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


def told(seen: Seen) -> Mapping[str, Any]:
    """A frame as ``cohelm people --json`` says it: time, how far to trust it, and who is there.

    ``pose`` is that of the robot, x, y and heading, in the frame in which people are told.
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


class Tracks:
    """What a whole recording comes to, frame by frame."""

    def __init__(self) -> None:
        self.frames = 0
        self.begin = math.nan
        """Time of the first frame, s."""
        self.end = math.nan
        """The latest time of any frame, s."""
        self.holes: list[tuple[float, float]] = []
        """From when to when nothing was read, s."""
        self.most = 0
        """People told at once."""
        self.sensing: Counter[Sensing] = Counter()
        self.groups: set[int] = set()
        """Ids."""
        self.way = Travelled()
        self._trails: dict[int, list[tuple[float, float, float]]] = {}

    def add(self, seen: Seen) -> None:
        """One more frame."""
        time, people = seen.observation.time, seen.perceived.people
        self.begin = self.begin if self.frames else time
        if self.frames and time - self.end > HOLE:
            self.holes.append((self.end, time))
        self.end = max(time, self.end) if self.frames else time
        self.frames += 1
        self.most = max(self.most, len(people))
        self.sensing[seen.perceived.sensing] += 1
        self.way.add(seen.whence, seen.way)
        self.groups |= set(seen.perceived.groups.id.tolist())
        for who, (x, y) in zip(people.id.tolist(), people.mean[:, :2].tolist(), strict=True):
            self._trails.setdefault(who, []).append((time, x, y))

    @property
    def trails(self) -> dict[int, Floats]:
        """Id → (k, 3) of (time s, x, y m)."""
        return {who: np.array(trail) for who, trail in self._trails.items()}

    def lasting(self, seconds: float = LASTING) -> list[int]:
        """Ids of the tracks that live longer, s."""
        return [who for who, trail in self._trails.items() if trail[-1][0] - trail[0][0] > seconds]

    def taken_over(self, seconds: float = 1.5, distance: float = 0.7) -> int:
        """How often a track seems to go on under another id: what can be said without labels.

        One begins within so many seconds (s) after another ended, or up to as long before, and
        within ``distance`` (m) of where that one's last second would have led it by then.
        """
        trails = sorted(self.trails.values(), key=lambda each: float(each[0, 0]))
        return sum(_goes_on(trail, trails, seconds, distance) for trail in trails)


def _goes_on(trail: Floats, trails: Sequence[Floats], seconds: float, distance: float) -> bool:
    """Whether a trail (k, 3) takes over from another one."""
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
