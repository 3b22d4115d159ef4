"""Convert cohelm's values to ROS 2 messages.

Messages share their parts (stamps, headers): never change a part of another message.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid
from cohelm.messages import Inertial, PointCloud, RiderCommand, Scan
from cohelm.recordings.bags.ros_messages import store

_FLOAT32 = 7
"""Type FLOAT32 of a PointField."""
_UNKNOWN = np.zeros(36)
"""Unknown covariance."""


@functools.cache
def of(type_: str) -> Any:
    """Class of a message type, as ``nav_msgs/msg/Path``."""
    return store(2).types[type_]


def schema(type_: str) -> bytes:
    """Definition of a type and its parts, as embedded in bags."""
    return store(2).generate_msgdef(type_, ros_version=2)[0].encode()


def serialised(message: Any) -> bytes:
    """Serialise a message in CDR, little-endian."""
    return bytes(store(2).serialize_cdr(message, message.__msgtype__))


def nanoseconds(time: float) -> int:
    """Convert a time from s to ns; 0 where it is not finite."""
    return max(round(1e9 * time), 0) if math.isfinite(time) else 0


@functools.lru_cache(maxsize=16)
def stamp(time: float) -> Any:
    """A Time, of seconds."""
    sec, nanosec = divmod(nanoseconds(time), 1_000_000_000)
    return of("builtin_interfaces/msg/Time")(sec=min(sec, 2**31 - 1), nanosec=nanosec)


@functools.lru_cache(maxsize=16)
def duration(seconds: float) -> Any:
    """Convert a duration ≥ 0 to Duration."""
    whole, nanoseconds = divmod(round(1e9 * seconds), 10**9)
    return of("builtin_interfaces/msg/Duration")(sec=whole, nanosec=nanoseconds)


def header(time: float, frame: str) -> Any:
    """A Header for ``frame`` at ``time``."""
    return of("std_msgs/msg/Header")(stamp=stamp(time), frame_id=frame)


def point(x: float, y: float, z: float = 0.0) -> Any:
    """A Point, m."""
    return of("geometry_msgs/msg/Point")(x=float(x), y=float(y), z=float(z))


def vector(x: float, y: float, z: float = 0.0) -> Any:
    """A Vector3."""
    return of("geometry_msgs/msg/Vector3")(x=float(x), y=float(y), z=float(z))


def turned(yaw: float, roll: float = 0.0, pitch: float = 0.0) -> Any:
    """The Quaternion of angles about the fixed axes (REP-103), rad."""
    if roll == pitch == 0.0:
        return of("geometry_msgs/msg/Quaternion")(
            0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)
        )
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return of("geometry_msgs/msg/Quaternion")(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def pose(X: Floats) -> Any:
    """A Pose on the floor, of (x, y, yaw)."""
    x, y, yaw = X.tolist()
    return of("geometry_msgs/msg/Pose")(position=point(x, y), orientation=turned(yaw))


def posed(time: float, frame: str, X: Floats) -> Any:
    """A PoseStamped, of (x, y, yaw)."""
    return of("geometry_msgs/msg/PoseStamped")(header=header(time, frame), pose=pose(X))


def twist(V: Floats) -> Any:
    """A Twist, of (v_x, v_y, ω)."""
    x, y, turn = V.tolist()
    return of("geometry_msgs/msg/Twist")(linear=vector(x, y), angular=vector(0.0, 0.0, turn))


def twisted(time: float, frame: str, V: Floats) -> Any:
    """A TwistStamped."""
    return of("geometry_msgs/msg/TwistStamped")(header=header(time, frame), twist=twist(V))


def odometry(time: float, frames: tuple[str, str], X: Floats, V: Floats) -> Any:
    """An Odometry: the pose X of the second of ``frames`` in the first, and its own twist V."""
    where = of("geometry_msgs/msg/PoseWithCovariance")(pose=pose(X), covariance=_UNKNOWN)
    how = of("geometry_msgs/msg/TwistWithCovariance")(twist=twist(V), covariance=_UNKNOWN)
    parent, child = frames
    return of("nav_msgs/msg/Odometry")(
        header=header(time, parent), child_frame_id=child, pose=where, twist=how
    )


def transform(time: float, frames: tuple[str, str], X: Floats) -> Any:
    """A TFMessage with one transform: (x, y, z, roll, pitch, yaw) of the second frame."""
    x, y, z, roll, pitch, yaw = X.tolist()
    moved = of("geometry_msgs/msg/Transform")(
        translation=vector(x, y, z), rotation=turned(yaw, roll, pitch)
    )
    parent, child = frames
    stamped = of("geometry_msgs/msg/TransformStamped")(
        header=header(time, parent), child_frame_id=child, transform=moved
    )
    return of("tf2_msgs/msg/TFMessage")(transforms=[stamped])


def path(time: float, frame: str, poses: Floats) -> Any:
    """A Path, of poses (k, 3)."""
    return of("nav_msgs/msg/Path")(
        header=header(time, frame), poses=[posed(time, frame, each) for each in poses]
    )


def grid(time: float, frame: str, map_: OccupancyGrid) -> Any:
    """An OccupancyGrid."""
    rows, cols = map_.shape
    info = of("nav_msgs/msg/MapMetaData")(
        map_load_time=stamp(time),
        resolution=map_.resolution,
        width=cols,
        height=rows,
        origin=pose(map_.X_MG),
    )
    return of("nav_msgs/msg/OccupancyGrid")(
        header=header(time, frame), info=info, data=np.ascontiguousarray(map_.data).ravel()
    )


def scan(frame: str, sweep: Scan) -> Any:
    """A LaserScan; single precision, as the type has it."""
    last = sweep.angle_min + max(len(sweep.ranges) - 1, 0) * sweep.angle_increment
    return of("sensor_msgs/msg/LaserScan")(
        header=header(sweep.time, frame),
        angle_min=sweep.angle_min,
        angle_max=last,
        angle_increment=sweep.angle_increment,
        time_increment=0.0,
        scan_time=0.0,
        range_min=0.0,
        range_max=sweep.range_max,
        ranges=sweep.ranges.astype(np.float32),
        intensities=np.empty(0, np.float32),
    )


def cloud(frame: str, sweep: PointCloud) -> Any:
    """A PointCloud2."""
    field = of("sensor_msgs/msg/PointField")
    points = np.ascontiguousarray(sweep.points, dtype="<f4")
    return of("sensor_msgs/msg/PointCloud2")(
        header=header(sweep.time, frame),
        height=1,
        width=len(points),
        fields=[
            field(name=axis, offset=4 * k, datatype=_FLOAT32, count=1)
            for k, axis in enumerate("xyz")
        ],
        is_bigendian=False,
        point_step=12,
        row_step=12 * len(points),
        data=points.reshape(-1).view(np.uint8),
        is_dense=bool(np.isfinite(points).all()),
    )


def joy(frame: str, hand: RiderCommand) -> Any:
    """A Joy with two axes: forward and left."""
    return of("sensor_msgs/msg/Joy")(
        header=header(hand.heartbeat, frame),
        axes=hand.deflection.astype(np.float32),
        buttons=np.empty(0, np.int32),
    )


def imu(frame: str, reading: Inertial) -> Any:
    """An Imu; its yaw is unknown and 0, and so are all covariances."""
    roll, pitch = reading.tilt
    return of("sensor_msgs/msg/Imu")(
        header=header(reading.time, frame),
        orientation=turned(0.0, float(roll), float(pitch)),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(*reading.turn_rate),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(*reading.acceleration),
        linear_acceleration_covariance=np.zeros(9),
    )


def number(content: float) -> Any:
    """A Float64."""
    return of("std_msgs/msg/Float64")(data=float(content))


def octets(content: bytes) -> Any:
    """A UInt8MultiArray."""
    layout = of("std_msgs/msg/MultiArrayLayout")(dim=[], data_offset=0)
    return of("std_msgs/msg/UInt8MultiArray")(layout=layout, data=np.frombuffer(content, np.uint8))


def status(time: float, name: str, message: str, facts: Mapping[str, str], *, fine: bool) -> Any:
    """A DiagnosticArray with one status; one that is not fine is a warning."""
    kind = of("diagnostic_msgs/msg/DiagnosticStatus")
    pair = of("diagnostic_msgs/msg/KeyValue")
    said = kind(
        level=kind.OK if fine else kind.WARN,
        name=name,
        message=message,
        hardware_id="",
        values=[pair(key=key, value=text) for key, text in facts.items()],
    )
    return of("diagnostic_msgs/msg/DiagnosticArray")(header=header(time, ""), status=[said])


def markers(each: Iterable[Any]) -> Any:
    """A MarkerArray."""
    return of("visualization_msgs/msg/MarkerArray")(markers=list(each))
