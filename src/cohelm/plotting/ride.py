"""Picture of a whole ride."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

from cohelm import messages
from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid, Places
from cohelm.navigation import Tick
from cohelm.plotting import canvas
from cohelm.robots import Robot
from cohelm.simulation import FloorRelief
from cohelm.social.outlines import group_outlines, space_outline


class DrawnRide(Protocol):
    """Parts of a ride that a picture shows; k instants, n people, w wishes."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""

    @property
    def world(self) -> OccupancyGrid:
        """True obstacles, on the same cells."""

    @property
    def relief(self) -> FloorRelief:
        """Heights of the floor."""

    @property
    def places(self) -> Places:
        """Named places."""

    @property
    def robot(self) -> Robot:
        """The chair."""

    @property
    def goal(self) -> Floats:
        """(2,), m."""

    @property
    def prefer(self) -> Floats:
        """(w, 2), m."""

    @property
    def time(self) -> Floats:
        """(k,), s."""

    @property
    def pose(self) -> Floats:
        """(k, 3)."""

    @property
    def twist(self) -> Floats:
        """(k, 3)."""

    @property
    def eta(self) -> Floats:
        """(k,)."""

    @property
    def people(self) -> Floats:
        """(k, n, 4)."""

    @property
    def people_radius(self) -> Floats:
        """(n,), m."""

    @property
    def gap_people(self) -> Floats:
        """(k, n), m."""

    @property
    def path(self) -> messages.Path | None:
        """The first route."""

    @property
    def ticks(self) -> Sequence[Tick]:
        """Some of the navigator's ticks."""

    @property
    def closest(self) -> Tick | None:
        """The tick nearest to a person."""


def draw_ride(ride: DrawnRide, file: Path, title: str = "") -> None:
    """Draw a ride.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure, axes = canvas.sheet(ride_window(ride), title)
    canvas.draw_floor(axes, ride.grid, ride.world, ride.relief)
    canvas.draw_places(axes, ride.places, marks(ride))
    if ride.path is not None:
        canvas.draw_route(axes, ride.path.points, ride.path.without_wishes)
    _draw_people(axes, ride)
    _draw_closest(axes, ride)
    _draw_track(figure, axes, ride)
    canvas.draw_wishes(axes, ride.prefer)
    canvas.draw_ends(axes, ride.pose[0], ride.goal)
    if (ride.world.occupied() & ~ride.grid.occupied()).any():
        axes.plot([], [], "s", color=canvas.UNMAPPED, markersize=9, label="not on the map")
    canvas.draw_legend(figure, axes, drop=0.42)
    canvas.save(figure, file)


def ride_window(ride: DrawnRide) -> tuple[float, float, float, float]:
    """Window with the track, the route and the wishes, with a margin; m."""
    points = [ride.pose[:, :2], ride.goal[None], ride.prefer]
    if ride.path is not None:
        points += [ride.path.points, ride.path.without_wishes]
    return canvas.around(np.concatenate(points), ride.grid, margin=3.5)


def marks(ride: DrawnRide) -> Floats:
    """Points (j, 2) that names must not cover: track, goal, people at the closest moment; m."""
    points = [ride.pose[::5, :2], ride.goal[None], ride.prefer]
    if ride.gap_people.size:
        people = ride.people[int(np.argmin(ride.gap_people.min(axis=1))), :, :2]
        points.append(people[np.isfinite(people[:, 0])])
    return np.concatenate(points)


def space_outlines(tick: Tick) -> list[Floats]:
    """Outlines (j, 2) of the personal space of each tracked person, m."""
    return [] if tick.spaces is None else outlines_of(tick.people, tick.spaces)


def outlines_of(people: messages.People, spaces: messages.SocialSpaces) -> list[Floats]:
    """Outlines (j, 2) of each person's space now, their body included, m."""
    return [
        space_outline(spaces, (i, 0, 0), people.mean[i, :2], margin=float(people.radius[i]))
        for i in range(len(people))
    ]


def _draw_people(axes: Axes, ride: DrawnRide) -> None:
    """Draw each person's track, dotted, with a small circle at its start."""
    if not ride.people.shape[1]:
        return
    tracks = ride.people[:, :, :2].transpose(1, 0, 2)
    axes.add_collection(
        LineCollection(
            list(tracks), colors=canvas.PERSON, linewidths=0.9, alpha=0.75,
            linestyles=[(0, (1, 2))], zorder=3,
        )
    )  # fmt: skip
    axes.plot(
        *tracks[:, 0].T, linestyle="none", marker="o", markersize=3.5, color=canvas.PERSON,
        markerfacecolor="white", zorder=3,
    )  # fmt: skip
    axes.plot([], [], color=canvas.PERSON, linewidth=1.2, linestyle=(0, (1, 2)), label="people")


def _draw_closest(axes: Axes, ride: DrawnRide) -> None:
    """Draw chair, people and their personal spaces at the closest moment."""
    if ride.closest is None or not ride.people.shape[1]:
        return
    at = int(np.argmin(ride.gap_people.min(axis=1)))
    for ring in space_outlines(ride.closest):
        axes.add_patch(
            Polygon(
                ring, facecolor=canvas.SPACE, edgecolor=canvas.SPACE, alpha=0.25, zorder=2
            )
        )  # fmt: skip
        axes.plot(*ring.T, color=canvas.SPACE, linewidth=0.9, zorder=6)
    hulls = group_outlines(ride.closest.spaces)
    for ring in hulls:
        axes.plot(*ring.T, color=canvas.GROUP, linewidth=1.3, linestyle=canvas.HULL, zorder=6)
    if hulls:
        axes.plot([], [], color=canvas.GROUP, linestyle=canvas.HULL, label="groups")
    for i, radius in enumerate(ride.people_radius):
        if np.isnan(ride.people[at, i, 0]):
            continue  # not present
        axes.add_patch(
            Circle(
                tuple(ride.people[at, i, :2]), radius, facecolor=canvas.PERSON,
                edgecolor="white", linewidth=0.6, zorder=7,
            )
        )  # fmt: skip
    axes.add_patch(
        canvas.footprint(
            ride.robot, ride.pose[at], facecolor="white", edgecolor=canvas.CHAIR,
            linewidth=1.6, zorder=7,
        )
    )  # fmt: skip
    axes.plot(
        [], [], linestyle="none", marker="o", color=canvas.PERSON, markeredgecolor=canvas.SPACE,
        markeredgewidth=4, markersize=9, label="people and their spaces at the closest moment",
    )  # fmt: skip


def _draw_track(figure: Figure, axes: Axes, ride: DrawnRide) -> None:
    """Draw the driven track, coloured by η, with the footprint every three seconds."""
    every = max(round(0.2 / _step(ride)), 1)
    points = ride.pose[::every, :2]
    eta = ride.eta[::every]
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    axes.plot(*points.T, color=canvas.INK, linewidth=5.4, solid_capstyle="round", zorder=8)
    lines = LineCollection(
        list(pieces), cmap=canvas.ETA, linewidths=3.6, capstyle="round", zorder=9
    )
    lines.set_array(eta[:-1])
    lines.set_clim(0.0, 1.0)
    axes.add_collection(lines)
    for pose in ride.pose[:: max(round(3.0 / _step(ride)), 1)]:
        axes.add_patch(
            canvas.footprint(
                ride.robot, pose, fill=False, edgecolor=canvas.CHAIR, linewidth=0.7,
                alpha=0.55, zorder=8,
            )
        )  # fmt: skip
    axes.add_line(
        Line2D([], [], color=canvas.ETA(0.2), linewidth=4, label="driven, footprint every 3 s")
    )
    box = axes.get_position()
    width, height = 2.8 / figure.get_figwidth(), 0.1 / figure.get_figheight()
    bar = figure.add_axes((box.x1 - width, box.y0 - 0.62 / figure.get_figheight(), width, height))
    figure.colorbar(lines, cax=bar, orientation="horizontal")
    bar.set_xticks([0.0, 1.0], ["chair steers  η = 0", "η = 1  rider steers"], fontsize=8)
    left, right = bar.get_xticklabels()
    left.set_horizontalalignment("left")
    right.set_horizontalalignment("right")
    bar.tick_params(length=0, pad=2, colors=canvas.INK)


def _step(ride: DrawnRide) -> float:
    return float(ride.time[1] - ride.time[0]) if len(ride.time) > 1 else 1.0
