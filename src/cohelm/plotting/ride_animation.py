"""Animation of a ride."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import CircleCollection, PolyCollection
from matplotlib.figure import Figure

from cohelm.arrays import Bytes, Integers
from cohelm.geometry import transform
from cohelm.plotting import canvas
from cohelm.plotting.animation import INTERVAL, WIDTH, check_animation, titled, write_film
from cohelm.plotting.ride import DrawnRide, marks, ride_window, space_outlines
from cohelm.social.outlines import group_outlines

DENSITY = 80.0
"""Minimum resolution of a frame, px/inch, for letters that can be read."""


@dataclass(frozen=True)
class AnimationStyle:
    """Size and speed of an animation."""

    width: int = WIDTH
    """Width of a frame, px."""
    max_frames: int | None = None
    """Frames at most; a longer ride skips instants and plays faster."""
    speed_up: float = 1.0
    """Playback speed; 1 is real time."""


def animate_ride(
    ride: DrawnRide, file: Path, title: str = "", style: AnimationStyle | None = None
) -> None:
    """Write a ride as .gif or .mp4.

    Args:
        ride: The ride.
        file: Animation to write.
        title: Title; the playback speed is added unless it is 1.
        style: Size and speed.

    Raises:
        ConfigError: if the file cannot be written as an animation.
    """
    check_animation(file)
    style = style or AnimationStyle()
    shown = _moments(ride)
    speed = style.speed_up
    if style.max_frames is not None and len(shown) > style.max_frames:
        speed *= len(shown) / style.max_frames
        shown = shown[np.linspace(0, len(shown) - 1, style.max_frames).astype(int)]
    title = titled(title, float(f"{speed:.2g}"))
    middle = next(_frames(ride, title, [len(ride.time) // 2], style.width))
    shades = canvas.ETA(np.linspace(0.0, 1.0, 256))[:, :3]
    frames = _frames(ride, title, shown, style.width)
    write_film(frames, file, sample=middle, shades=shades, speed_up=style.speed_up)


def _frames(ride: DrawnRide, title: str, moments: Iterable[int], width: int) -> Iterator[Bytes]:
    """Draw RGB images (height, width, 3) of some instants, the static parts once."""
    figure, axes = canvas.sheet(ride_window(ride), title, min(width / DENSITY, canvas.LARGEST[0]))
    figure.set_dpi(width / figure.get_figwidth())
    canvas.draw_floor(axes, ride.grid, ride.world, ride.relief)
    canvas.draw_places(axes, ride.places, marks(ride))
    if ride.path is not None:
        canvas.draw_route(axes, ride.path.points, ride.path.without_wishes)
    canvas.draw_wishes(axes, ride.prefer)
    canvas.draw_ends(axes, ride.pose[0], ride.goal)
    canvas.draw_legend(figure, axes)
    agg: Any = FigureCanvasAgg(figure)
    agg.draw()
    still = agg.copy_from_bbox(figure.bbox)
    for at in moments:
        agg.restore_region(still)
        _draw_moment(figure, axes, ride, at)
        yield np.asarray(agg.buffer_rgba())[..., :3].copy()


def _moments(ride: DrawnRide) -> Integers:
    """Indices of the shown instants, the last included."""
    times = np.arange(ride.time[0], ride.time[-1], INTERVAL)
    return np.unique([*np.searchsorted(ride.time, times), len(ride.time) - 1])


def _draw_moment(figure: Figure, axes: Axes, ride: DrawnRide, at: int) -> None:
    """Draw one instant over the still parts: track so far, spaces, people, chair, clock."""
    track = axes.plot(*ride.pose[: at + 1, :2].T, color=canvas.ETA(0.25), linewidth=2.5)
    known = [tick for tick in ride.ticks if tick.observation.time <= ride.time[at] + 1e-9]
    spaces = PolyCollection(
        space_outlines(known[-1]) if known else [],
        facecolors=canvas.SPACE, edgecolors=canvas.SPACE, alpha=0.3,
    )  # fmt: skip
    groups = PolyCollection(
        group_outlines(known[-1].spaces) if known else [],
        facecolors="none", edgecolors=canvas.GROUP, linewidths=1.4, linestyles=[canvas.HULL],
    )  # fmt: skip
    people = _bodies(axes, ride, at)
    chair = canvas.footprint(
        ride.robot, ride.pose[at], facecolor=canvas.ETA(float(ride.eta[at])),
        edgecolor=canvas.CHAIR, linewidth=1.6,
    )  # fmt: skip
    nose = axes.plot(
        *transform(ride.pose[at], np.array([[0.0, 0.0], [0.6, 0.0]])).T, color="white", linewidth=2
    )
    clock = axes.text(
        0.99, 0.97, _caption(ride, at), transform=axes.transAxes, ha="right", va="top",
        fontsize=11, family="monospace", color=canvas.INK,
        bbox={"boxstyle": "round", "facecolor": "white", "edgecolor": canvas.PLAIN_ROUTE},
    )  # fmt: skip
    axes.add_collection(spaces)
    axes.add_collection(groups)
    axes.add_collection(people)
    axes.add_patch(chair)
    for artist in (spaces, groups, *track, people, chair, *nose, clock):
        figure.draw_artist(artist)
        artist.remove()


def _bodies(axes: Axes, ride: DrawnRide, at: int) -> CircleCollection:
    """The people's discs; sizes of a CircleCollection are areas in points²."""
    box = axes.get_window_extent()
    points_per_metre = box.width / np.ptp(axes.get_xlim()) * 72.0 / axes.figure.dpi
    there = np.isfinite(ride.people[at, :, 0])
    return CircleCollection(
        sizes=np.pi * (ride.people_radius[there] * points_per_metre) ** 2,
        offsets=ride.people[at, there, :2], transOffset=axes.transData,
        facecolors=canvas.PERSON, edgecolors="white", linewidths=0.6,
    )  # fmt: skip


def _caption(ride: DrawnRide, at: int) -> str:
    gap = ride.gap_people[at].clip(min=0.0).min(initial=np.inf)
    nearest = f"  nearest {gap:4.1f} m" if np.isfinite(gap) else ""
    return f"{ride.time[at]:5.1f} s  {ride.twist[at, 0]:4.2f} m/s  η {ride.eta[at]:.2f}{nearest}"
