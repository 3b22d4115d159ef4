"""Record a ride: every tick as ROS messages for viewers, and exactly, to the bit.

MCAP file that grows during a ride and can be read up to its last second at any time.
"""

from __future__ import annotations

import contextlib
import json
import signal
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy as np

from cohelm.arrays import Floats, identical
from cohelm.errors import RecordingError
from cohelm.messages import Observation, PointCloud, Request, Scan
from cohelm.navigation import Tick
from cohelm.recordings.rides import markers as draw
from cohelm.recordings.rides import ros_messages as ros
from cohelm.recordings.rides.exact import pack
from cohelm.recordings.rides.ride import (
    DRAWN,
    MAP,
    RIDE_TOPIC,
    ROBOT,
    TICK_TOPIC,
    RideFacts,
    RideTick,
    digest_of,
)
from cohelm.robots import Robot
from cohelm.simulation import GroundTruth

FLUSH = 1.0
"""Interval of chunks, s of the ride; a killed recorder loses at most this."""


class McapWriter:
    """Writer of ROS 2 messages in chunks, each written when it is full or a second has passed.

    Args:
        file: File to write; it must not exist, its folder must.
        stream: Open stream to write to instead; ``file`` is then its name.

    Raises:
        RecordingError: if it exists or cannot be written.
    """

    def __init__(self, file: Path, stream: IO[bytes] | None = None) -> None:
        from mcap.writer import CompressionType, Writer  # noqa: PLC0415  # only to record

        self._file = file
        try:
            self._stream = stream or file.open("xb")
        except FileExistsError:
            problem = "exists already; remove it or name another file"
            raise RecordingError(problem, file=file) from None
        except OSError as cause:
            raise self._unwritable(cause) from None
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._flushed = 0
        self._now = 0
        try:
            self._call(self._writer.start, profile="ros2", library="cohelm")
        except RecordingError:
            self._stream.close()
            raise

    def write(self, topic: str, message: Any, time: float) -> None:
        """Write a message at a time, s, that never decreases.

        Raises:
            RecordingError: if the disk is full.
        """
        self._now = max(self._now, ros.nanoseconds(time))
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channel(topic, message.__msgtype__)
        self._call(self._writer.add_message, channel, self._now, ros.serialised(message), self._now)
        if self._now - self._flushed >= FLUSH * 1e9:
            self.flush()

    def flush(self) -> None:
        """Write the messages since the last chunk.

        Raises:
            RecordingError: if the disk is full.
        """
        self._flushed = self._now
        self._call(self._writer.flush)

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Write metadata, which viewers list.

        Raises:
            RecordingError: if the disk is full.
        """
        self._call(self._writer.add_metadata, name, dict(facts))

    def attach(self, name: str, kind: str, data: bytes) -> None:
        """Attach a file; ``kind`` is its media type.

        Raises:
            RecordingError: if the disk is full.
        """
        self._call(self._writer.add_attachment, 0, self._now, name, kind, data)

    def close(self) -> None:
        """Write the rest and the index.

        Raises:
            RecordingError: if the disk is full; what was written before can be read.
        """
        try:
            self._call(self._writer.finish)
        finally:
            with contextlib.suppress(OSError):
                self._stream.close()

    def _channel(self, topic: str, type_: str) -> int:
        if type_ not in self._schemas:
            self._schemas[type_] = self._call(
                self._writer.register_schema, type_, "ros2msg", ros.schema(type_)
            )
        self._channels[topic] = self._call(
            self._writer.register_channel, topic, "cdr", self._schemas[type_]
        )
        return self._channels[topic]

    def _call(self, write: Any, *what: Any, **named: Any) -> Any:
        try:
            return write(*what, **named)
        except OSError as cause:
            raise self._unwritable(cause) from None

    def _unwritable(self, cause: OSError) -> RecordingError:
        return RecordingError(f"cannot be written ({cause.strerror or cause})", file=self._file)


@contextlib.contextmanager
def delayed_interrupt() -> Iterator[None]:
    """Delay Ctrl-C until the end of a block, so that it cannot tear a write apart.

    Only Python's own handler is delayed, and only in the main thread.

    Raises:
        KeyboardInterrupt: at the end, if there was one.
    """
    main = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT)
    if not main or before is not signal.default_int_handler:
        yield
        return
    signals: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: signals.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if signals:
        raise KeyboardInterrupt


_ROUNDING = 1e-9


class RideRecorder:
    """Watcher of a ride that writes it to an MCAP file, at most a second behind.

    It only reads, so a recorded ride equals an unrecorded one. Use it in a ``with`` statement;
    however that ends, the file is kept and has its index.

    Args:
        file: File to write; must not exist.
        facts: Facts about the ride.

    Raises:
        RecordingError: if the file exists or cannot be written.
    """

    def __init__(self, file: Path, facts: RideFacts) -> None:
        self._file = McapWriter(file)
        self._sensors = _Sensors(facts.robot)
        self._last: Tick | None = None
        self._count = 0
        self._drawn = -np.inf
        self._facts = facts

    def __enter__(self) -> Self:
        """Write what is known before the ride; close the file if that fails."""
        try:
            self._begin(self._facts)
        except BaseException as error:
            self.__exit__(type(error), error, error.__traceback__)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write the rest; an error in doing so does not hide the first one."""
        with delayed_interrupt():
            try:
                self._file.close()
            except RecordingError as also:
                if error is None:
                    raise
                error.add_note(str(also))

    def __call__(self, tick: Tick, truth: GroundTruth | None) -> None:
        """Record a tick; a real chair has no ground truth.

        Raises:
            RecordingError: if the disk is full.
        """
        with delayed_interrupt():
            self._add(tick, truth)

    def _begin(self, facts: RideFacts) -> None:
        scenario = json.dumps(dict(facts.scenario), indent=1).encode()
        self._file.note("cohelm", _metadata(facts))
        self._file.attach("scenario.json", "application/json", scenario)
        self._file.write(RIDE_TOPIC, ros.octets(pack(facts)), 0.0)
        self._file.write("/map", ros.grid(0.0, MAP, facts.grid), 0.0)
        self._file.write("/robot", draw.footprint(0.0, facts.robot), 0.0)
        self._file.flush()

    def _add(self, tick: Tick, truth: GroundTruth | None) -> None:
        last, now = self._last, tick.observation.time
        request = None if _same_request(tick, last) else tick.request
        exact = RideTick(
            number=self._count,
            observation=tick.observation,
            request=request,
            decision=tick.decision,
            digest=digest_of(tick),
        )
        self._write(TICK_TOPIC, ros.octets(pack(exact)), now)
        self._write_numbers(tick, now)
        self._write_readings(tick.observation, now)
        if request is not None:
            self._write_request(request, now)
        if tick.path is not None and (last is None or tick.path is not last.path):
            self._write("/plan", ros.path(now, MAP, _with_headings(tick.path.points)), now)
        due = now - self._drawn >= DRAWN - _ROUNDING
        if due or last is None or tick.decision.reason is not last.decision.reason:
            self._write("/status", _status(tick), now)
        if due:
            self._drawn = now
            self._write_drawings(tick, now)
            if truth is not None:
                self._write_truth(truth, now)
        self._last = tick
        self._count += 1

    def end(self, outcome: str) -> None:
        """Write the outcome of the ride as metadata.

        Raises:
            RecordingError: if the disk is full.
        """
        self._file.note("cohelm end", {"outcome": outcome, "ticks": str(self._count)})

    def _write(self, topic: str, message: Any, time: float) -> None:
        self._file.write(topic, message, time)

    def _write_numbers(self, tick: Tick, now: float) -> None:
        seen = tick.observation
        there = np.array([seen.pose[0], seen.pose[1], 0.0, 0.0, 0.0, seen.pose[2]])
        self._write("/tf", ros.transform(now, (MAP, ROBOT), there), now)
        self._write("/odom", ros.odometry(now, (MAP, ROBOT), seen.pose, seen.twist), now)
        self._write("/cmd_vel", ros.twisted(now, ROBOT, tick.decision.twist), now)
        self._write("/eta", ros.number(tick.authority.eta if tick.authority else 0.0), now)
        if seen.inertial is not None:
            self._write("/imu", ros.imu(ROBOT, seen.inertial), now)
        if seen.rider is not None:
            self._write("/rider", ros.joy(ROBOT, seen.rider), now)

    def _write_readings(self, seen: Observation, now: float) -> None:
        for scan in seen.scans:
            frame = self._frame(scan, now)
            self._write(self._sensors.topic("/scan", frame), ros.scan(frame, scan), now)
        for cloud in seen.clouds:
            frame = self._frame(cloud, now)
            self._write(self._sensors.topic("/points", frame), ros.cloud(frame, cloud), now)

    def _frame(self, reading: Scan | PointCloud, now: float) -> str:
        """Frame of the sensor; its mount is written when it is first met."""
        frame, new = self._sensors.frame(reading)
        if new:
            X_RS = reading.mount if len(reading.mount) == 6 else _upright(reading.mount)
            self._write("/tf_static", ros.transform(now, (ROBOT, frame), X_RS), now)
        return frame

    def _write_request(self, request: Request, now: float) -> None:
        self._write("/goal", ros.posed(now, MAP, np.append(request.goal, 0.0)), now)
        self._write("/wishes", draw.wishes(now, request.wishes), now)

    def _write_drawings(self, tick: Tick, now: float) -> None:
        ahead = np.empty((0, 3)) if tick.plan is None else tick.plan.poses
        self._write("/local_plan", ros.path(now, MAP, ahead), now)
        self._write("/people", draw.people(now, tick.people), now)
        self._write("/predictions", draw.futures(now, tick.predictions), now)
        self._write("/social_spaces", draw.spaces(now, tick.people, tick.spaces), now)
        self._write("/groups", draw.groups(now, tick.spaces), now)

    def _write_truth(self, truth: GroundTruth, now: float) -> None:
        where = ros.odometry(truth.time, (MAP, f"{ROBOT}_truth"), truth.pose, truth.twist)
        self._write("/truth/odom", where, now)
        crowd = truth.crowd
        bodies = np.where(crowd.there[:, None], crowd.position, np.nan)
        self._write("/truth/people", draw.true_people(now, bodies, crowd.radius), now)


class _Sensors:
    """Names of the sensors: the chair's, or numbers where a reading fits none."""

    def __init__(self, robot: Robot) -> None:
        self._several = {"/scan": len(robot.lasers) > 1, "/points": len(robot.cloud_mounts) > 1}
        mounts = (*robot.lasers, *robot.cloud_mounts)
        self._known = {tuple(map(float, mount.pose)): mount.name for mount in reversed(mounts)}
        self._met: dict[tuple[float, ...], str] = {}

    def frame(self, reading: Scan | PointCloud) -> tuple[str, bool]:
        """The frame, and True where it is new."""
        mount = tuple(reading.mount.tolist())
        if mount in self._met:
            return self._met[mount], False
        name = self._known.get(mount, f"sensor_{len(self._met) + 1}")
        taken = set(self._met.values())
        self._met[mount] = name if name not in taken else f"{name}_{len(self._met) + 1}"
        return self._met[mount], True

    def topic(self, kind: str, frame: str) -> str:
        """``/scan``, followed by the sensor's name where the chair has several of the kind."""
        return f"{kind}/{frame}" if self._several[kind] else kind


def _same_request(tick: Tick, last: Tick | None) -> bool:
    if last is None:
        return False
    return tick.request is last.request or identical(tick.request, last.request)


def _upright(mount: Floats) -> Floats:
    """X_RS (6,) of a planar scanner at unknown height."""
    return np.array([mount[0], mount[1], 0.0, 0.0, 0.0, mount[2]])


def _with_headings(points: Floats) -> Floats:
    """Poses (k, 3) along a polyline (k, 2)."""
    if len(points) < 2:
        return np.column_stack([points, np.zeros(len(points))])
    step = np.diff(points, axis=0)
    heading = np.arctan2(step[:, 1], step[:, 0])
    return np.column_stack([points, np.append(heading, heading[-1])])


def _status(tick: Tick) -> Any:
    decision, plan = tick.decision, tick.plan
    reason = decision.reason
    facts = {
        "mode": tick.request.mode.value,
        "eta": f"{tick.authority.eta if tick.authority else 0.0:.3f}",
        "reason": reason.value if reason else "",
        "emergency": str(decision.emergency).lower(),
        "trouble": tick.planning_error,
        "plan": plan.status.value if plan else "",
        "recovery": tick.recovery.stage.value if tick.recovery and tick.recovery.stage else "",
        "sensing": tick.sensing.value,
        "people_from": tick.people.source,
    }
    said = reason.sentence if reason else "no limitation"
    time = tick.observation.time
    return ros.status(time, "cohelm", said, facts, fine=reason is None)


def _metadata(facts: RideFacts) -> dict[str, str]:
    return {
        "scenario": facts.name,
        "seed": str(facts.seed),
        "robot": facts.robot.name,
        "format": str(facts.format),
        **{f"version {part}": text for part, text in facts.versions.items()},
    }
