"""Decode ROS messages and convert them to cohelm's."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cohelm.arrays import Floats, Floats32
from cohelm.messages import PointCloud, Scan
from cohelm.recordings.api import max_range, without_far_points
from cohelm.recordings.bags.files import BagMessage

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

SCAN = "sensor_msgs/msg/LaserScan"
CLOUD = "sensor_msgs/msg/PointCloud2"
ODOMETRY = "nav_msgs/msg/Odometry"
POSES = "geometry_msgs/msg/PoseArray"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
OLD_TRANSFORMS = "tf/msg/tfMessage"

ENCODINGS = frozenset({"cdr", "ros1"})
"""Encodings of ROS 2 and ROS 1."""

_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Types of a PointField."""
_MAX_BEAMS = 1_000_000
_MAX_GAP = 0.1
"""Maximum difference between the last beam and ``angle_max``, rad: drivers that count one beam more
or less differ by a step or two."""


def decode(message: BagMessage) -> Any:
    """Decode a message with the types that ROS defines, not those that a bag embeds.

    Raises:
        ValueError: if the encoding is not one of ROS, or the bytes are not a message of that type.
    """
    data, type_ = message.data, message.type
    if message.encoding not in ENCODINGS:
        raise ValueError(f"its encoding {message.encoding[:20]!r} is not read, cdr and ros1 are")
    try:
        if message.encoding == "ros1":
            return store(1).deserialize_ros1(data, type_)
        return store(2).deserialize_cdr(data, type_)
    except Exception as error:  # damaged bytes raise many kinds of errors in rosbags
        raise ValueError(f"not a {type_.rpartition('/')[2]}: {error}") from None


@functools.cache
def store(version: int) -> Typestore:
    """Type store of ROS 1 or 2."""
    from rosbags.typesys import (  # noqa: PLC0415  # only where a bag is read
        Stores,
        get_types_from_msg,
        get_typestore,
    )

    if version == 2:
        return get_typestore(Stores.ROS2_HUMBLE)
    types = get_typestore(Stores.ROS1_NOETIC)
    for type_ in (TRANSFORMS, OLD_TRANSFORMS):
        text = "geometry_msgs/TransformStamped[] transforms"
        types.register(get_types_from_msg(text, type_))
    return types


def stamp(header: Any) -> float:
    """Time of a header, s; 0 where it has none."""
    return float(header.stamp.sec) + 1e-9 * float(header.stamp.nanosec)


def transform(pose: Any) -> tuple[float, ...]:
    """(x, y, z, q_x, q_y, q_z, q_w) of a Pose or a Transform."""
    p = pose.position if hasattr(pose, "position") else pose.translation
    q = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    return p.x, p.y, p.z, q.x, q.y, q.z, q.w


def scan(message: Any, time: float, X_RS: Floats) -> Scan:
    """Convert a LaserScan of a sensor mounted at ``X_RS`` (6,), upright or upside down.

    After REP-117, and as older drivers do: 0, below ``range_min`` or −inf is a dropout; at or
    beyond ``range_max`` is no return.

    Raises:
        ValueError: if the directions of its beams are not valid.
    """
    ranges = np.array(message.ranges, dtype=float)
    first, step = float(message.angle_min), float(message.angle_increment)
    if len(ranges) > _MAX_BEAMS or not math.isfinite(first) or not 0.0 < abs(step) < math.tau:
        raise ValueError(f"{len(ranges)} beams from {first:g} rad by {step:g} rad are not a scan")
    with np.errstate(invalid="ignore"):
        lower = np.nan_to_num(float(message.range_min), nan=0.0, posinf=0.0)
        ranges[(ranges <= 0.0) | (ranges < lower)] = np.nan
        reach = float(message.range_max)
        if not 0.0 < reach < math.inf:
            reach = np.nextafter(max(ranges[np.isfinite(ranges)], default=0.0), np.inf)
        ranges[ranges >= reach] = np.inf
    if abs(X_RS[3]) > math.pi / 2.0:  # mounted upside down: beams run the other way
        first, step = -first, -step
    if step < 0.0:
        first, step, ranges = first + (len(ranges) - 1) * step, -step, ranges[::-1]
    return Scan(
        time=time,
        mount=X_RS[[0, 1, 5]],
        angle_min=first,
        angle_increment=step,
        range_max=reach,
        ranges=ranges,
    )


def angle_problem(message: Any) -> str:
    """Description of a LaserScan whose last beam is not at ``angle_max``; empty if it is."""
    step, last = float(message.angle_increment), float(message.angle_max)
    end = float(message.angle_min) + (len(message.ranges) - 1) * step
    gap = abs(math.remainder(end - last, math.tau)) if math.isfinite(last) else math.inf
    if gap <= max(2.0 * abs(step), _MAX_GAP):
        return ""
    return (
        f"its beams end at {end:.2f} rad, angle_max is {last:.2f}: their directions, from "
        f"angle_min and angle_increment, may be wrong"
    )


def cloud(message: Any, time: float, X_RS: Floats) -> tuple[PointCloud, int]:
    """Convert a PointCloud2 of a sensor mounted at ``X_RS`` (6,); the range is the farthest return.

    A point at (0, 0, 0) is no return, as many drivers write it.

    Returns:
        The cloud, and the number of points that are too far away for any sensor: no returns.

    Raises:
        ValueError: if its fields do not match its data, or x, y or z is missing.
    """
    points = _points(message)
    points[~points.any(axis=1)] = np.nan
    points, far = without_far_points(points)
    return PointCloud(time=time, mount=X_RS, points=points, range_max=max_range(points)), far


def _points(message: Any) -> Floats32:
    """Points (p, 3) of fields in any order, type and padding."""
    shape = height, width = int(message.height), int(message.width)
    if height * width == 0:
        return np.empty((0, 3), dtype=np.float32)
    row, step, size = int(message.row_step), int(message.point_step), len(message.data)
    plain = height * width * step
    # Drivers write 0, the width or the whole size as row_step: without padding it is not needed.
    if size == plain:
        row = width * step
    # The last row may lack its padding, but no point may be missing or left over.
    least, most = (height - 1) * row + width * step, height * row
    if width * step > row or not least <= size <= most:
        raise ValueError(
            f"a PointCloud2 of {height} × {width} points of {step} bytes, row_step {row}, "
            f"needs {max(least, plain)} bytes and has {size}"
        )
    order = ">" if message.is_bigendian else "<"
    columns = [_column(message, axis, order, shape, row) for axis in "xyz"]
    points = np.empty((height * width, 3), dtype=np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        for k, column in enumerate(columns):
            points[:, k] = column.ravel()
    return points


def _column(message: Any, axis: str, order: str, shape: tuple[int, int], row: int) -> NDArray[Any]:
    field = {field.name: field for field in message.fields}.get(axis)
    if field is None or field.datatype not in _NUMBERS:
        raise ValueError(f"a PointCloud2 without a numeric field {axis}")
    number = np.dtype(order + _NUMBERS[field.datatype])
    if field.offset + number.itemsize > message.point_step:
        raise ValueError(f"a PointCloud2 whose field {axis} lies outside its points")
    return np.ndarray(
        shape,
        dtype=number,
        buffer=np.ascontiguousarray(message.data),
        offset=int(field.offset),
        strides=(row, int(message.point_step)),
    )
