"""Who was seen in a recording, through time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

from cohelm.arrays import Bytes
from cohelm.pictures import canvas
from cohelm.pictures.film import WIDTH, check_animation, write_film
from cohelm.pictures.people import (
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
    record: PeopleRecord, moments: Sequence[PeopleMoment], file: Path, title: str = ""
) -> None:
    """Write a recording's instants, one or more, as .gif or .mp4.

    Raises:
        ConfigError: if the file cannot be written as an animation.
    """
    check_animation(file)
    fullest = max(moments, key=lambda each: len(each.people))
    sample = next(_frames(record, moments, title, [fullest]))
    write_film(_frames(record, moments, title, moments), file, sample=sample)


def _frames(
    record: PeopleRecord,
    moments: Sequence[PeopleMoment],
    title: str,
    shown: Iterable[PeopleMoment],
) -> Iterator[Bytes]:
    """RGB images (height, width, 3) of some instants, the still parts drawn once."""
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
