"""Animation of the people in a recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

from cohelm.arrays import Bytes
from cohelm.plotting import canvas
from cohelm.plotting.animation import WIDTH, check_animation, titled, write_film
from cohelm.plotting.people import (
    LATELY,
    PeopleMoment,
    PeopleRecord,
    draw_moment,
    draw_people_legend,
    draw_trails,
    people_sheet,
    trails_until,
)


def animate_people(
    record: PeopleRecord,
    moments: Sequence[PeopleMoment],
    file: Path,
    title: str = "",
    speed_up: float = 1.0,
) -> None:
    """Write one or more instants of a recording as .gif or .mp4.

    Raises:
        ConfigError: if the file cannot be written as an animation.
    """
    check_animation(file)
    title = titled(title, speed_up)
    fullest = max(moments, key=lambda each: len(each.people))
    sample = next(_frames(record, moments, title, [fullest]))
    frames = _frames(record, moments, title, moments)
    write_film(frames, file, sample=sample, speed_up=speed_up)


def _frames(
    record: PeopleRecord,
    moments: Sequence[PeopleMoment],
    title: str,
    shown: Iterable[PeopleMoment],
) -> Iterator[Bytes]:
    """Draw RGB images (height, width, 3) of some instants, the static parts once."""
    figure, axes = people_sheet(record, moments, title)
    figure.set_dpi(WIDTH / figure.get_figwidth())
    labelled = [moment for moment in moments if len(moment.truth)]
    draw_people_legend(figure, axes, (labelled or moments)[0])
    agg: Any = FigureCanvasAgg(figure)
    agg.draw()
    still = agg.copy_from_bbox(figure.bbox)
    for moment in shown:
        agg.restore_region(still)
        time = moment.observation.time
        drawn = draw_trails(axes, trails_until(record, time, LATELY)) + draw_moment(axes, moment)
        drawn.append(
            axes.text(
                0.99, 0.97, f"{time - record.begin:6.1f} s  {len(moment.people):2d} people",
                transform=axes.transAxes, ha="right", va="top", fontsize=11, zorder=30,
                family="monospace", color=canvas.INK,
                bbox={"boxstyle": "round", "facecolor": "white", "edgecolor": canvas.PLAIN_ROUTE},
            )
        )  # fmt: skip
        for artist in sorted(drawn, key=lambda each: float(each.get_zorder())):
            figure.draw_artist(artist)
        for artist in drawn:
            artist.remove()
        yield np.asarray(agg.buffer_rgba())[..., :3].copy()
