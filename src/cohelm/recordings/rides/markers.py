"""Markers of a recorded ride: people, predictions, spaces, groups, wishes, footprint."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import People, Predictions, SocialSpaces, Wish
from cohelm.recordings.rides import ros_messages as ros
from cohelm.recordings.rides.ride import MAP, ROBOT
from cohelm.robots import Robot
from cohelm.social.outlines import group_outlines, space_outline

_TALL = 1.7
"""Height at which people are drawn, m."""
_CORNERS = 24
"""Number of edges of an outline."""
_LOOKING = 0.6
"""Length of a standing person's arrow, m; a walking person's is as long as 1 s of walking."""


class _Paint(NamedTuple):
    """Red, green, blue, opacity; 0…1."""

    r: float
    g: float
    b: float
    a: float


_SEEN = _Paint(0.88, 0.32, 0.25, 0.9)
_TRUE = _Paint(0.35, 0.40, 0.48, 0.5)
_SPACE = _Paint(0.90, 0.55, 0.10, 0.9)
_GROUP = _Paint(0.55, 0.35, 0.75, 0.9)
_FUTURE = _Paint(0.24, 0.44, 0.71, 0.9)
_WISH = _Paint(0.18, 0.62, 0.31, 0.9)
_AVOID = _Paint(0.76, 0.23, 0.23, 0.9)
_CHAIR = _Paint(0.11, 0.15, 0.19, 1.0)


def people(time: float, seen: People) -> Any:
    """Each person as a cylinder, an arrow in the direction of motion or gaze, and the id."""
    out = [_clear(time)]
    speed = np.hypot(seen.mean[:, 2], seen.mean[:, 3])
    course = np.where(speed > 0.1, np.arctan2(seen.mean[:, 3], seen.mean[:, 2]), seen.heading)
    for k in range(len(seen)):
        x, y = seen.mean[k, :2].tolist()
        id_ = int(seen.id[k])
        out.append(_body(time, id_, (x, y), float(seen.radius[k]), _SEEN))
        if np.isfinite(course[k]):
            out.append(_arrow(time, id_, (x, y, float(course[k])), max(float(speed[k]), _LOOKING)))
        out.append(_text(time, id_, (x, y), str(id_)))
    return ros.markers(out)


def true_people(time: float, position: Floats, radius: Floats) -> Any:
    """Bodies (n, 2) with radii (n,), m; people who are absent (NaN) are skipped."""
    here = np.flatnonzero(np.isfinite(position).all(axis=1))
    bodies = (_body(time, int(k), position[k].tolist(), float(radius[k]), _TRUE) for k in here)
    return ros.markers([_clear(time), *bodies])


def futures(time: float, predicted: Predictions | None) -> Any:
    """Most likely prediction of each person."""
    out = [_clear(time)]
    if predicted is not None and predicted.mean.size:
        best = predicted.weight.argmax(axis=1)
        paths = predicted.mean[np.arange(len(best)), best, ::3]
        out += [_line(time, "future", k, path, _FUTURE, 0.04) for k, path in enumerate(paths)]
    return ros.markers(out)


def spaces(time: float, seen: People, social: SocialSpaces | None) -> Any:
    """Personal space of each person, now."""
    out = [_clear(time)]
    if social is not None:
        for k in range(len(seen)):
            line = space_outline(social, (k, 0, 0), seen.mean[k, :2], count=_CORNERS)
            out.append(_line(time, "space", k, line, _SPACE, 0.03))
    return ros.markers(out)


def groups(time: float, social: SocialSpaces | None) -> Any:
    """Group spaces, now."""
    out = [_clear(time)]
    if social is not None and social.groups is not None:
        for id_, line in zip(social.groups.id, group_outlines(social), strict=True):
            out.append(_line(time, "group", int(id_), line, _GROUP, 0.03))
    return ros.markers(out)


def wishes(time: float, wanted: Iterable[Wish]) -> Any:
    """Points to pass, lines to follow, zones to keep out of."""
    out = [_clear(time)]
    for k, wish in enumerate(wanted):
        paint = _AVOID if wish.kind == "avoid" else _WISH
        if wish.kind == "avoid" and len(wish.points) > 2:
            corners = np.vstack([wish.points, wish.points[:1]])
            out.append(_line(time, wish.kind, k, corners, paint, 0.05))
        elif wish.kind == "stroke" or (wish.kind == "avoid" and len(wish.points) == 2):
            wide = max(2.0 * wish.radius, 0.05)
            out.append(_line(time, wish.kind, k, wish.points, paint, wide))
        else:
            reach = max(wish.radius, 0.15)
            for j, spot in enumerate(wish.points.tolist()):
                out.append(_disc(time, f"{wish.kind} {k}", j, spot, reach, paint))
    return ros.markers(out)


def footprint(time: float, robot: Robot) -> Any:
    """The chair's outline; viewers move it with its frame."""
    corners = np.vstack([robot.outline, robot.outline[:1]])
    line = _line(time, "footprint", 0, corners, _CHAIR, 0.04)
    line.header = ros.header(time, ROBOT)
    line.frame_locked = True
    return ros.markers([line])


def _marker(time: float, shape: str, names: tuple[str, int], **given: Any) -> Any:
    """A marker with defaults for everything that is not given."""
    ns, id_ = names
    marker = copy(_template())
    marker.header = ros.header(time, MAP)
    marker.ns = ns
    marker.id = (id_ + 2**31) % 2**32 - 2**31
    marker.type = getattr(marker, shape)
    for name, content in given.items():
        setattr(marker, name, content)
    return marker


@functools.cache
def _template() -> Any:
    """A marker with defaults."""
    kind = ros.of("visualization_msgs/msg/Marker")
    nothing = np.empty(0, np.uint8)
    return kind(
        header=ros.header(0.0, MAP),
        ns="",
        id=0,
        type=kind.SPHERE,
        action=kind.ADD,
        pose=ros.pose(np.zeros(3)),
        scale=ros.vector(1.0, 1.0, 1.0),
        color=ros.of("std_msgs/msg/ColorRGBA")(r=0.0, g=0.0, b=0.0, a=1.0),
        lifetime=ros.of("builtin_interfaces/msg/Duration")(sec=0, nanosec=0),
        frame_locked=False,
        points=[],
        colors=[],
        texture_resource="",
        texture=ros.of("sensor_msgs/msg/CompressedImage")(
            header=ros.header(0.0, ""), format="", data=nothing
        ),
        uv_coordinates=[],
        text="",
        mesh_resource="",
        mesh_file=ros.of("visualization_msgs/msg/MeshFile")(filename="", data=nothing),
        mesh_use_embedded_materials=False,
    )


def _clear(time: float) -> Any:
    """Marker that deletes what was drawn on this topic before."""
    action = ros.of("visualization_msgs/msg/Marker").DELETEALL
    return _marker(time, "SPHERE", ("", 0), action=action)


@functools.cache
def _colour(paint: _Paint) -> Any:
    return ros.of("std_msgs/msg/ColorRGBA")(**paint._asdict())


def _body(time: float, id_: int, spot: Iterable[float], radius: float, paint: _Paint) -> Any:
    at = ros.pose(np.array([*spot, 0.0]))
    at.position.z = 0.5 * _TALL
    size = ros.vector(2.0 * radius, 2.0 * radius, _TALL)
    return _marker(time, "CYLINDER", ("body", id_), pose=at, scale=size, color=_colour(paint))


def _arrow(time: float, id_: int, at: tuple[float, float, float], length: float) -> Any:
    size = ros.vector(length, 0.06, 0.06)
    where = ros.pose(np.array(at))
    return _marker(time, "ARROW", ("course", id_), pose=where, scale=size, color=_colour(_SEEN))


def _text(time: float, id_: int, spot: tuple[float, float], text: str) -> Any:
    at = ros.pose(np.array([*spot, 0.0]))
    at.position.z = _TALL + 0.2
    size = ros.vector(0.0, 0.0, 0.25)
    return _marker(
        time,
        "TEXT_VIEW_FACING",
        ("id", id_),
        pose=at,
        scale=size,
        color=_colour(_CHAIR),
        text=text,
    )


def _disc(time: float, ns: str, id_: int, spot: list[float], radius: float, paint: _Paint) -> Any:
    size = ros.vector(2.0 * radius, 2.0 * radius, 0.02)
    at = ros.pose(np.array([*spot, 0.0]))
    return _marker(time, "CYLINDER", (ns, id_), pose=at, scale=size, color=_colour(paint))


def _line(time: float, ns: str, id_: int, points: Floats, paint: _Paint, width: float) -> Any:
    point = ros.of("geometry_msgs/msg/Point")
    return _marker(
        time,
        "LINE_STRIP",
        (ns, id_),
        points=[point(x, y, 0.0) for x, y in points.tolist()],
        scale=ros.vector(width, 0.0, 0.0),
        color=_colour(paint),
    )
