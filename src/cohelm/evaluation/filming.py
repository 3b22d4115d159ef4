"""Pictures and films of what was seen in a recording, gathered frame by frame."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.watching import LASTING, Seen, Tracks
from cohelm.maps import OccupancyGrid
from cohelm.messages import Predictions, RiderProfile
from cohelm.perception import Predictor
from cohelm.pictures.film import INTERVAL
from cohelm.pictures.people import (
    BACKDROP,
    PeopleMoment,
    PeopleRecord,
    draw_people,
    thinned,
)
from cohelm.pictures.people_film import animate_people
from cohelm.recordings import Labels
from cohelm.social import SocialModel

FILMED = 5_000
"""Points of the clouds that each image of a film shows at most, and that are kept for it."""


class Filming:
    """Keeps the instants that a picture and a film need, and of them no more than is drawn.

    Args:
        predictor, social_model: that give everyone their space.
        grid: the map, where there is one.
        at: the picture's instant since ``begin``, s; None: the first with the most people of those
            who have been there for ``LASTING``, or of all, where nobody has.
        moving: whether there will be a film.
        begin: the time from which instants are counted, s; None: that of the first frame added.
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
        """The instant of the picture since the beginning, s; NaN before the first frame."""
        return math.nan if self._chosen is None else self._chosen.observation.time - self._begin

    def add(self, seen: Seen, labels: Labels | None) -> None:
        """One more frame, and where people truly were, if anybody said."""
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

    def draw(self, tracks: Tracks, file: Path, title: str) -> None:
        """Write the picture.

        Raises:
            ConfigError: if it cannot be written.
        """
        if self._chosen is not None:
            n = len(self._chosen.people)
            says = f"{title}: {n} {'person' if n == 1 else 'people'} at {self.at:.1f} s"
            draw_people(self._record(tracks), self._chosen, file, says)

    def animate(self, tracks: Tracks, file: Path, title: str) -> None:
        """Write the film.

        Raises:
            ConfigError: if it cannot be written.
        """
        animate_people(self._record(tracks), self._film, file, title)

    def _rank_of(self, seen: Seen) -> tuple[float, float, float]:
        time, perceived = seen.observation.time, seen.perceived
        if self._at is not None:
            return -abs(time - self._begin - self._at), 0.0, 0.0
        stayed = sum(time - self._since[who] >= LASTING for who in perceived.people.id.tolist())
        return float(stayed), float(len(perceived.people)), float(len(perceived.groups.id))

    def _record(self, tracks: Tracks) -> PeopleRecord:
        return PeopleRecord(begin=self._begin, trails=tracks.trails, grid=self._grid)

    def _moment(
        self, seen: Seen, labels: Labels | None, predictions: Predictions, points: int
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
