"""Pictures and films of perceived people, gathered frame by frame."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.perception.recording_view import LASTING, PerceivedFrame, RecordingSummary
from cohelm.maps import OccupancyGrid
from cohelm.messages import Predictions, RiderProfile
from cohelm.perception import Predictor
from cohelm.plotting.animation import INTERVAL
from cohelm.plotting.people import (
    BACKDROP,
    PeopleMoment,
    PeopleRecord,
    draw_people,
    thinned,
)
from cohelm.plotting.people_animation import animate_people
from cohelm.recordings import Labels
from cohelm.social import SocialModel

FILMED = 5_000
"""Largest number of points of an image of a film."""


class FilmRecorder:
    """Collects the instants of a picture and a film, and of them only what is drawn.

    Args:
        predictor, social_model: parts that compute personal spaces.
        grid: the map, if there is one.
        at: instant of the picture since ``begin``, s; None: the first one with the most people who
            were present for ``LASTING``, else with the most people.
        moving: collect a film.
        begin: origin of the instants, s; None: time of the first frame.
    """

    def __init__(
        self,
        predictor: Predictor,
        social_model: SocialModel,
        *,
        grid: OccupancyGrid | None = None,
        at: float | None = None,
        moving: bool = False,
        begin: float | None = None,
    ) -> None:
        self._predictor = predictor
        self._memory: Any = None
        self._social = social_model
        self._grid = grid
        self._at = at
        self._moving = moving
        self._begin = math.nan if begin is None else begin
        self._since: dict[int, float] = {}
        self._chosen: PeopleMoment | None = None
        self._rank = (-math.inf,) * 3
        self._film: list[PeopleMoment] = []
        self._slot: int | None = None

    @property
    def at(self) -> float:
        """Instant of the picture since the beginning, s; NaN before the first frame."""
        return math.nan if self._chosen is None else self._chosen.observation.time - self._begin

    def add(self, seen: PerceivedFrame, labels: Labels | None) -> None:
        """Add one frame with its labels, if it has any."""
        time, people = seen.observation.time, seen.perceived.people
        self._begin = time if math.isnan(self._begin) else self._begin
        predictions, self._memory = self._predictor.predict(people, 1, 0.1, self._memory)
        for who in people.id.tolist():
            self._since.setdefault(who, time)

        rank = self._rank_of(seen)
        if rank > self._rank:
            self._rank = rank
            self._chosen = self._moment(seen, labels, predictions, BACKDROP)
        slot = math.floor((time - self._begin) / INTERVAL + 1e-6)
        if self._moving and slot != self._slot:
            self._film.append(self._moment(seen, labels, predictions, FILMED))
        self._slot = slot

    def draw(self, tracks: RecordingSummary, file: Path, title: str) -> None:
        """Write the picture.

        Raises:
            ConfigError: if it cannot be written.
        """
        if self._chosen is not None:
            n = len(self._chosen.people)
            says = f"{title}: {n} {'person' if n == 1 else 'people'} at {self.at:.1f} s"
            draw_people(self._record(tracks), self._chosen, file, says)

    def animate(
        self, tracks: RecordingSummary, file: Path, title: str, speed_up: float = 1.0
    ) -> None:
        """Write the film.

        Raises:
            ConfigError: if it cannot be written.
        """
        animate_people(self._record(tracks), self._film, file, title, speed_up)

    def _rank_of(self, seen: PerceivedFrame) -> tuple[float, float, float]:
        time, perceived = seen.observation.time, seen.perceived
        if self._at is not None:
            return -abs(time - self._begin - self._at), 0.0, 0.0
        stayed = sum(time - self._since[who] >= LASTING for who in perceived.people.id.tolist())
        return float(stayed), float(len(perceived.people)), float(len(perceived.groups.id))

    def _record(self, tracks: RecordingSummary) -> PeopleRecord:
        return PeopleRecord(begin=self._begin, trails=tracks.trails, grid=self._grid)

    def _moment(
        self, seen: PerceivedFrame, labels: Labels | None, predictions: Predictions, points: int
    ) -> PeopleMoment:
        perceived = seen.perceived
        spaces = self._social.spaces(
            perceived.people, perceived.groups, predictions, seen.observation.twist, RiderProfile()
        )
        return PeopleMoment(
            observation=thinned(seen.observation, points),
            detections=tuple(replace(each, heights=None) for each in perceived.detections),
            people=perceived.people,
            groups=perceived.groups,
            spaces=spaces,
            truth=np.empty((0, 2)) if labels is None else labels.position,
        )
