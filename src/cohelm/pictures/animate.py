"""A ride as a moving picture: GIF by Pillow, MP4 where ffmpeg is installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import CircleCollection, PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from cohelm.arrays import Bytes, Integers
from cohelm.errors import ConfigError
from cohelm.geometry import transform
from cohelm.pictures import canvas
from cohelm.pictures.ride import RideRecord, marks, ride_window, space_outlines

INTERVAL = 0.25
"""Of the ride between two frames, s."""
SPEED_UP = 2.5
"""Played faster than life."""
WIDTH = 900
"""Of a frame, px."""


def check_animation(file: Path) -> None:
    """Refuse a file that no animation can be written to, before the work is done.

    Raises:
        ConfigError: naming the option and what to do.
    """
    kind = file.suffix.lower()
    if kind not in {".gif", ".mp4"}:
        raise ConfigError(f"{file}: write an animation as .gif or .mp4", key="--animate")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError("an .mp4 needs ffmpeg, which is not here; write a .gif", key="--animate")
    canvas.check_folder(file, "--animate")


def animate_ride(ride: RideRecord, file: Path, title: str = "") -> None:
    """Write a ride as .gif or .mp4.

    Raises:
        ConfigError: if the file cannot be written as an animation.
    """
    check_animation(file)
    frames = _frames(ride, title, _moments(ride))
    try:
        if file.suffix.lower() == ".gif":
            middle = next(_frames(ride, title, [len(ride.time) // 2]))
            _write_gif(frames, _palette(middle), file)
        else:
            _write_mp4(frames, file)
    except OSError as cause:
        raise canvas.not_written(file, "--animate", cause) from None


def _frames(ride: RideRecord, title: str, moments: Iterable[int]) -> Iterator[Bytes]:
    """RGB images (height, width, 3) of some instants, the still parts drawn once."""
    figure, axes = canvas.sheet(ride_window(ride), title)
    figure.set_dpi(WIDTH / figure.get_figwidth())
    canvas.draw_floor(axes, ride.grid, ride.world)
    canvas.draw_places(axes, ride.places, marks(ride))
    if ride.path is not None:
        canvas.draw_route(axes, ride.path.points, ride.path.without_wishes)
    canvas.draw_wishes(axes, ride.prefer)
    canvas.draw_ends(axes, ride.pose[0], ride.goal)
    canvas.draw_scale_bar(axes)
    canvas.draw_legend(figure, axes)
    agg: Any = FigureCanvasAgg(figure)
    agg.draw()
    still = agg.copy_from_bbox(figure.bbox)
    for at in moments:
        agg.restore_region(still)
        _draw_moment(figure, axes, ride, at)
        yield np.asarray(agg.buffer_rgba())[..., :3].copy()


def _moments(ride: RideRecord) -> Integers:
    """Indices of the shown instants, the last included."""
    times = np.arange(ride.time[0], ride.time[-1], INTERVAL)
    return np.unique([*np.searchsorted(ride.time, times), len(ride.time) - 1])


def _draw_moment(figure: Figure, axes: Axes, ride: RideRecord, at: int) -> None:
    """Draw one instant over the still parts: track so far, spaces, people, chair, clock."""
    track = axes.plot(*ride.pose[: at + 1, :2].T, color=canvas.ETA(0.25), linewidth=2.5)
    known = [tick for tick in ride.ticks if tick.observation.time <= ride.time[at] + 1e-9]
    spaces = PolyCollection(
        space_outlines(known[-1]) if known else [],
        facecolors=canvas.SPACE, edgecolors=canvas.SPACE, alpha=0.3,
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
    axes.add_collection(people)
    axes.add_patch(chair)
    for artist in (spaces, *track, people, chair, *nose, clock):
        figure.draw_artist(artist)
        artist.remove()


def _bodies(axes: Axes, ride: RideRecord, at: int) -> CircleCollection:
    """The people's discs; sizes of a CircleCollection are areas in points²."""
    box = axes.get_window_extent()
    points_per_metre = box.width / np.ptp(axes.get_xlim()) * 72.0 / axes.figure.dpi
    return CircleCollection(
        sizes=np.pi * (ride.people_radius * points_per_metre) ** 2,
        offsets=ride.people[at, :, :2], transOffset=axes.transData,
        facecolors=canvas.PERSON, edgecolors="white", linewidths=0.6,
    )  # fmt: skip


def _caption(ride: RideRecord, at: int) -> str:
    gap = ride.gap_people[at].clip(min=0.0).min(initial=np.inf)
    nearest = f"  nearest {gap:4.1f} m" if np.isfinite(gap) else ""
    return f"{ride.time[at]:5.1f} s  {ride.twist[at, 0]:4.2f} m/s  η {ride.eta[at]:.2f}{nearest}"


def _write_gif(frames: Iterator[Bytes], palette: Image.Image, file: Path) -> None:
    """One palette for all frames: colours do not flicker, and the file stays small."""
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    milliseconds = [round(1000.0 * INTERVAL / SPEED_UP)] * len(images)
    milliseconds[-1] = 2000
    images[0].save(file, save_all=True, append_images=images[1:], duration=milliseconds, loop=0)


def _palette(frame: Bytes) -> Image.Image:
    """256 colours of a frame and of all the values of η, which it may not show."""
    shades = (canvas.ETA(np.linspace(0.0, 1.0, frame.shape[1]))[:, :3] * 255.0).astype(np.uint8)
    strip = np.broadcast_to(shades, (frame.shape[0] // 10, *shades.shape))
    return Image.fromarray(np.concatenate([frame, strip])).quantize(
        256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
    )


def _write_mp4(frames: Iterator[Bytes], file: Path) -> None:
    first = next(frames)
    height, width = (length - length % 2 for length in first.shape[:2])  # H.264 wants even sides
    command = (
        f"ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {width}x{height} "
        f"-r {SPEED_UP / INTERVAL:g} -i - -pix_fmt yuv420p"
    )
    with subprocess.Popen([*command.split(), str(file)], stdin=subprocess.PIPE) as ffmpeg:
        if ffmpeg.stdin is not None:
            for frame in (first, *frames):
                ffmpeg.stdin.write(frame[:height, :width].tobytes())
            ffmpeg.stdin.close()
    if ffmpeg.returncode:
        raise ConfigError(f"{file}: ffmpeg could not write it; write a .gif", key="--animate")
