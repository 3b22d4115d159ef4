"""Timeline of a ride for the page: samples at a fixed period, reasons with their times.

The same form holds a ride of a session, from its rows, and a recording, from its MCAP file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.evaluation.episode.ride import Ride
from cohelm.live.floor_model import RecordedFloor, recorded_floor
from cohelm.live.sessions.records import RideStop
from cohelm.reasons import Reason
from cohelm.recordings.bags.files import read_bag
from cohelm.recordings.bags.ros_messages import decode
from cohelm.recordings.rides.reader import RecordedRide

PERIOD = 0.2
"""Time between samples, s."""
MAX_SAMPLES = 6000
"""Maximum number of samples: 20 minutes; a longer ride has a longer period."""
MIN_DURATION = 0.1
"""Minimum duration of a reason, s; shorter ones are left out."""
GAP = 1.0
"""Maximum gap within one reason, s."""
SAME_TICK = 1e-6
_SPACING = 3
"""Every how many points of a route are told."""
Point = tuple[float, float]


class Timeline(Model):
    """Ride to look back at; lists have one entry for each sample."""

    period: float
    """s."""
    pose: tuple[tuple[float, float, float], ...]
    speed: tuple[float, ...]
    """Forward, m/s."""
    eta: tuple[float, ...]
    """Rider's share of the control authority, 0…1."""
    stick: tuple[Point, ...]
    """Forward and left, −1…1."""
    people: tuple[tuple[Point, ...], ...]
    """m."""
    reasons: tuple[RideStop, ...] = ()
    route: tuple[Point, ...] = ()
    goal: Point | None = None
    outline: tuple[Point, ...]
    """Corners of the chair in its own frame, m."""
    floor: RecordedFloor


def timeline_of(ride: Ride, stops: Sequence[RideStop]) -> Timeline:
    """Return the timeline of a ride of a session.

    Args:
        ride: Ride with at least one tick.
        stops: Its stops.
    """
    ticks, period = _samples(ride.time)
    positions = ride.people[ticks, :, :2]
    return Timeline(
        period=period,
        pose=tuple(_pose(pose) for pose in ride.pose[ticks]),
        speed=_numbers(ride.twist[ticks, 0]),
        eta=_numbers(ride.eta[ticks]),
        stick=tuple(_pair(stick) for stick in ride.stick[ticks]),
        people=tuple(_points(each) for each in positions),
        reasons=tuple(stop for stop in stops if stop.duration >= MIN_DURATION),
        route=_points(ride.path.points[::_SPACING]) if ride.path is not None else (),
        goal=_pair(ride.goal) if np.isfinite(ride.goal).all() else None,
        outline=_points(ride.robot.outline),
        floor=recorded_floor(ride.scenario, ride.grid),
    )


def timeline_of_recording(file: Path, warn: Callable[[str], None] | None = None) -> Timeline:
    """Return the timeline of an MCAP file that ``--record`` has written.

    Args:
        file: The recording.
        warn: Called with a line for everything that could not be read.

    Raises:
        RecordingError: It holds no ride of cohelm.
    """
    recorded = RecordedRide(file)
    ticks = [
        _Tick(
            time=each.observation.time,
            pose=each.observation.pose,
            speed=float(each.observation.twist[0]),
            stick=_stick(each.observation.rider),
            reason=each.decision.reason,
        )
        for each in recorded
    ]
    begun = ticks[0].time
    topics, damage = _Topics.of(file)
    for text in [*recorded.warnings, *damage]:
        if warn is not None:
            warn(text)
    chosen, period = _samples(np.array([tick.time for tick in ticks]) - begun)
    return Timeline(
        period=period,
        pose=tuple(_pose(ticks[k].pose) for k in chosen),
        speed=_numbers([ticks[k].speed for k in chosen]),
        eta=_numbers([topics.eta_at(k) for k in chosen]),
        stick=tuple(ticks[k].stick for k in chosen),
        people=tuple(topics.people_at(ticks[k].time) for k in chosen),
        reasons=_reasons(ticks),
        route=topics.route,
        outline=_points(recorded.facts.robot.outline),
        floor=recorded_floor(recorded.facts.scenario, recorded.facts.grid),
    )


class _Tick(NamedTuple):
    time: float
    pose: Floats
    speed: float
    stick: Point
    reason: Reason | None


class _Topics(NamedTuple):
    """Drawings and numbers of a recording besides its ticks."""

    eta: tuple[float, ...]
    """One for each tick."""
    people_times: Floats
    people: tuple[tuple[Point, ...], ...]
    route: tuple[Point, ...]

    @classmethod
    def of(cls, file: Path) -> tuple[_Topics, list[str]]:
        """Return what can be read, and a line for each topic with damaged messages."""
        damaged: dict[str, int] = {}
        eta: list[float] = []
        times: list[float] = []
        people: list[tuple[Point, ...]] = []
        route: tuple[Point, ...] = ()
        for message in read_bag([file], []):
            if message.topic not in {"/eta", "/people", "/plan"}:
                continue
            try:
                content = decode(message)
            except ValueError:
                damaged[message.topic] = damaged.get(message.topic, 0) + 1
                if message.topic == "/eta":
                    eta.append(eta[-1] if eta else 0.0)  # one for each tick
                continue
            if message.topic == "/eta":
                eta.append(float(content.data))
            elif message.topic == "/people":
                times.append(message.time)
                people.append(_bodies(content.markers))
            elif not route:
                poses = [each.pose.position for each in content.poses]
                route = _points(np.array([(p.x, p.y) for p in poses]).reshape(-1, 2)[::_SPACING])
        told = [f"{file}: {count} damaged messages of {topic}" for topic, count in damaged.items()]
        return cls(tuple(eta), np.array(times), tuple(people), route), told

    def eta_at(self, tick: int) -> float:
        """Rider's share at a tick; 0 after the end of a damaged file."""
        return self.eta[tick] if tick < len(self.eta) else 0.0

    def people_at(self, time: float) -> tuple[Point, ...]:
        """People of the last drawing before a time, s."""
        k = int(np.searchsorted(self.people_times, time + SAME_TICK, side="right")) - 1
        return self.people[k] if k >= 0 else ()


def _bodies(markers: Iterable[Any]) -> tuple[Point, ...]:
    """Positions of the people among markers: a body is a cylinder."""
    cylinder = 3
    found = [each for each in markers if getattr(each, "type", None) == cylinder]
    spots = [each.pose.position for each in found]
    return tuple((round(p.x, 2), round(p.y, 2)) for p in spots)


def _stick(rider: object) -> Point:
    deflection = getattr(rider, "deflection", None)
    return (0.0, 0.0) if deflection is None else _pair(deflection)


def _reasons(ticks: Sequence[_Tick]) -> tuple[RideStop, ...]:
    """Join ticks of the same reason, across short gaps."""
    found: list[RideStop] = []
    begun = ticks[0].time
    for tick in ticks:
        if tick.reason is None or tick.reason is Reason.ARRIVED:
            continue
        time, last = tick.time - begun, found[-1] if found else None
        joined = last is not None and last.code == tick.reason.value
        if last is not None and joined and time - (last.time + last.duration) <= GAP:
            found[-1] = last.model_copy(update={"duration": round(time - last.time, 2)})
        else:
            stop = RideStop(
                time=round(time, 2), duration=0.0, code=tick.reason.value, text=tick.reason.sentence
            )
            found.append(stop)
    return tuple(each for each in found if each.duration >= MIN_DURATION)


def _samples(times: Floats) -> tuple[list[int], float]:
    """Return the ticks that are told, for times from 0 on, and the period, s."""
    duration = float(times[-1] - times[0])
    period = max(PERIOD, duration / MAX_SAMPLES)
    due = np.arange(0.0, duration + 0.5 * period, period) + times[0]
    after = np.clip(np.searchsorted(times, due), 1, max(len(times) - 1, 1))
    after = np.minimum(after, len(times) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(due - times[before] <= times[after] - due, before, after)
    return nearer.tolist(), round(period, 3)


def _points(line: Floats) -> tuple[Point, ...]:
    """Points (k, 2 or more) that are finite, to the centimetre."""
    return tuple(
        (round(float(x), 2), round(float(y), 2))
        for x, y in line[:, :2]
        if math.isfinite(x) and math.isfinite(y)
    )


def _pose(pose: Floats) -> tuple[float, float, float]:
    x, y, heading = pose.tolist()
    return round(x, 3), round(y, 3), round(heading, 3)


def _pair(pair: Floats) -> Point:
    first, second = np.nan_to_num(pair).tolist()
    return round(first, 2), round(second, 2)


def _numbers(column: Iterable[float]) -> tuple[float, ...]:
    return tuple(round(float(each), 3) if math.isfinite(each) else 0.0 for each in column)
