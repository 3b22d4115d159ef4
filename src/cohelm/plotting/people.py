"""Picture of the people in a recording: returns, clusters, tracks, spaces and groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from scipy.spatial.transform import Rotation

from cohelm.arrays import Floats
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Groups, Observation, People, SocialSpaces
from cohelm.perception import Detections, pose_at
from cohelm.plotting import canvas
from cohelm.plotting.ride import outlines_of
from cohelm.social.outlines import group_outlines

TRACKS = ("#c2185b", "#0b7a75", "#b5541c", "#3d5a98", "#6a8a1f", "#8f3fb0", "#a33a2c", "#2f6f9f")
"""Colours of people by id; the id is also written beside the person."""
CLUSTERS = ("#9bb8d9", "#c7b39a", "#a9c9a4", "#d3abc3", "#b9b5dd", "#d8c58c")
"""Colour of clusters that are not people."""
BODY, PERHAPS = "#e0523f", "#f0b59a"
CLOUD, RETURNS = "#ccd3db", "#7b8794"
TRUE = "#1d2530"
SURE = 0.5
"""Confidence from which a cluster is drawn as a likely person."""
LATELY = 5.0
"""Duration of the part of each trail that is drawn strongly, s."""
MARGIN, LEAST = 2.0, 5.0
"""Margin around people and sensors, m, and minimum extent around the first sensor."""
BACKDROP = 20_000
"""Maximum number of drawn points of each cloud."""


@dataclass(frozen=True)
class PeopleMoment:
    """One instant of a recording."""

    observation: Observation
    detections: tuple[Detections, ...]
    people: People
    groups: Groups
    spaces: SocialSpaces | None = None
    """None: not requested."""
    truth: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """True positions of people, (k, 2), m."""


@dataclass(frozen=True)
class PeopleRecord:
    """Content of a picture of a whole recording."""

    begin: float
    """The recording's first instant, s."""
    trails: Mapping[int, Floats]
    """Id → (k, 3) of (time s, x, y m)."""
    grid: OccupancyGrid | None = None
    """The map, where there is one."""


def draw_people(record: PeopleRecord, moment: PeopleMoment, file: Path, title: str = "") -> None:
    """Write a picture of one instant, with the tracks of the whole recording.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure, axes = people_sheet(record, [moment], title)
    _draw_trails(axes, list(record.trails.items()), width=0.8, alpha=0.35)
    draw_trails(axes, trails_until(record, moment.observation.time, LATELY))
    draw_moment(axes, moment)
    if _walked(record):
        axes.plot([], [], color=TRACKS[0], linewidth=0.8, alpha=0.5, label="all tracks")
    draw_people_legend(figure, axes, moment, tracks=_walked(record))
    canvas.save(figure, file)


def people_sheet(
    record: PeopleRecord, moments: Sequence[PeopleMoment], title: str
) -> tuple[Figure, Axes]:
    """Make a figure whose window contains people and sensors, with the map."""
    figure, axes = canvas.sheet(_window(record, moments), title)
    axes.set_facecolor(canvas.FREE)
    if record.grid is not None:
        canvas.draw_floor(axes, record.grid)
    return figure, axes


def thinned(observation: Observation, points: int) -> Observation:
    """Thin each cloud of an observation evenly to at most ``points`` points."""
    clouds = tuple(
        replace(cloud, points=cloud.points[:: -(-len(cloud.points) // points) or 1].copy())
        for cloud in observation.clouds
    )
    return replace(observation, clouds=clouds)


def draw_moment(axes: Axes, moment: PeopleMoment) -> list[Any]:
    """Draw one instant; return the drawn elements."""
    drawn: list[Any] = [_dots(axes, _backdrop(moment.observation), CLOUD, 1.0, 1)]
    for found in moment.detections:
        drawn += _draw_clusters(axes, found)
    drawn += _draw_spaces(axes, moment)
    if len(moment.truth):
        drawn += axes.plot(
            *moment.truth.T, linestyle="none", marker="x", color=TRUE, markersize=7,
            markeredgewidth=1.4, zorder=10,
        )  # fmt: skip
    drawn += _draw_people(axes, moment.people)
    drawn += axes.plot(
        *_sensors(moment).T, linestyle="none", marker="^", markersize=9, color=canvas.CHAIR,
        markeredgecolor="white", zorder=11,
    )  # fmt: skip
    return drawn


def trails_until(record: PeopleRecord, time: float, span: float) -> list[tuple[int, Floats]]:
    """Part of each trail within ``span`` before ``time``, s."""
    cut = (
        (who, trail[(trail[:, 0] <= time + 1e-9) & (trail[:, 0] >= time - span)])
        for who, trail in record.trails.items()
    )
    return [(who, trail) for who, trail in cut if len(trail)]


def draw_trails(axes: Axes, trails: Sequence[tuple[int, Floats]]) -> list[Any]:
    """Draw trails (k, 3) of some people; return the drawn elements."""
    return _draw_trails(axes, trails, width=2.0, alpha=0.95)


def draw_people_legend(
    figure: Figure, axes: Axes, moment: PeopleMoment, *, tracks: bool = True
) -> None:
    """Add the legend below the axes, with the tracks if there are any."""
    if tracks:
        axes.plot([], [], color=TRACKS[0], linewidth=2.0, label=f"the last {LATELY:g} s of a track")
    _label_all(axes, moment)
    canvas.draw_legend(figure, axes)


def _walked(record: PeopleRecord) -> bool:
    """Check that there is any track; a single frame has none."""
    return any(len(trail) > 1 for trail in record.trails.values())


def _window(
    record: PeopleRecord, moments: Sequence[PeopleMoment]
) -> tuple[float, float, float, float]:
    sensors = np.concatenate([_sensors(moment) for moment in moments])
    shown = [trail[:, 1:] for trail in record.trails.values()]
    truth = [moment.truth for moment in moments]
    points = np.concatenate([sensors, *shown, *truth])
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    low = np.minimum(low, sensors.min(axis=0) - LEAST)
    high = np.maximum(high, sensors.max(axis=0) + LEAST)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _sensors(moment: PeopleMoment) -> Floats:
    """Positions (s, 2) of the sensors; of the robot if there is no reading."""
    origins = [found.origin for found in moment.detections]
    return np.array(origins or [moment.observation.pose[:2]])


def _backdrop(observation: Observation) -> Floats:
    """Some of the clouds' points, floor included, (k, 2), map frame, m."""
    out = [np.empty((0, 2))]
    for cloud in thinned(observation, BACKDROP).clouds:
        points = cloud.points[np.isfinite(cloud.points).all(axis=1)].astype(float)
        turned = Rotation.from_euler("xyz", cloud.mount[3:]).apply(points)
        on_robot = turned[:, :2] + cloud.mount[:2]
        out.append(transform(pose_at(observation, cloud.time), on_robot))
    return np.concatenate(out)


def _draw_clusters(axes: Axes, found: Detections) -> list[Any]:
    """Draw returns: in no cluster, in clusters, in possible and in likely people."""
    alone = (found.cluster_of_return < 0) & (found.detection_of_return < 0)
    shades = np.array([*CLUSTERS], dtype=object)[found.cluster_of_return % len(CLUSTERS)]
    thing = (found.cluster_of_return >= 0) & (found.detection_of_return < 0)
    body = found.detection_of_return >= 0
    sure = body & (np.append(found.confidence, 0.0)[found.detection_of_return] >= SURE)
    perhaps = body & ~sure
    return [
        _dots(axes, found.points[alone], RETURNS, 4.0, 3),
        _dots(axes, found.points[thing], list(shades[thing]), 9.0, 4),
        _dots(axes, found.points[perhaps], PERHAPS, 9.0, 5),
        _dots(axes, found.points[sure], BODY, 9.0, 6),
    ]


def _dots(axes: Axes, points: Floats, colour: Any, size: float, zorder: int) -> Any:
    return axes.scatter(points[:, 0], points[:, 1], s=size, c=colour, linewidths=0.0, zorder=zorder)


def _draw_spaces(axes: Axes, moment: PeopleMoment) -> list[Any]:
    if moment.spaces is None or not len(moment.people):
        return []
    eggs = PolyCollection(
        outlines_of(moment.people, moment.spaces), facecolors=canvas.SPACE,
        edgecolors=canvas.SPACE, alpha=0.3, zorder=2,
    )  # fmt: skip
    axes.add_collection(eggs, autolim=False)
    around = PolyCollection(
        group_outlines(moment.spaces), facecolors="none", edgecolors=canvas.GROUP, linewidths=1.6,
        linestyles=[canvas.HULL], zorder=5,
    )  # fmt: skip
    axes.add_collection(around, autolim=False)
    return [eggs, around]


def _draw_people(axes: Axes, people: People) -> list[Any]:
    """Draw a ring for each body, its velocity, and its id."""
    drawn: list[Any] = []
    for who, (x, y, vx, vy), radius in zip(people.id, people.mean, people.radius, strict=True):
        colour = _colour(int(who))
        round_ = radius * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 37))
        drawn += axes.plot(x + round_.real, y + round_.imag, color=colour, linewidth=1.8, zorder=8)
        drawn += axes.plot([x, x + vx], [y, y + vy], color=colour, linewidth=1.8, zorder=8)
        drawn.append(
            axes.annotate(
                str(who), (x, y), xytext=(7, 7), textcoords="offset points", fontsize=10,
                fontweight="bold", color=colour, zorder=13, annotation_clip=True,
                path_effects=[withStroke(linewidth=3.0, foreground="white")],
            )
        )  # fmt: skip
    return drawn


def _draw_trails(
    axes: Axes, trails: Sequence[tuple[int, Floats]], *, width: float, alpha: float
) -> list[Any]:
    lines = LineCollection(
        [trail[:, 1:] for _, trail in trails],
        colors=[_colour(who) for who, _ in trails] or None,
        linewidths=width, alpha=alpha, zorder=5,
    )  # fmt: skip
    axes.add_collection(lines, autolim=False)
    return [lines]


def _colour(who: int) -> str:
    return TRACKS[who % len(TRACKS)]


def _label_all(axes: Axes, moment: PeopleMoment) -> None:
    """Label the elements of the legend."""
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5}
    if moment.observation.clouds:
        axes.plot([], [], color=CLOUD, **dot, label="the cloud")
    axes.plot([], [], color=RETURNS, **dot, label="single returns")
    axes.plot([], [], color=CLUSTERS[0], **dot, label="other clusters")
    axes.plot([], [], color=PERHAPS, **dot, label="possible person")
    axes.plot([], [], color=BODY, **dot, label="likely person")
    axes.plot([], [], color=TRACKS[1], linewidth=1.8, label="tracked person, and position in 1 s")
    if moment.spaces is not None:
        axes.fill([], [], color=canvas.SPACE, alpha=0.3, label="personal space")
        axes.plot([], [], color=canvas.GROUP, linestyle=canvas.HULL, label="group")
    if len(moment.truth):
        axes.plot([], [], color=TRUE, linestyle="none", marker="x", label="label")
    axes.plot(
        [], [], linestyle="none", marker="^", markersize=8, color=canvas.CHAIR, label="sensor"
    )
