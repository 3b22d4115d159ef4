"""Pictures and films of what was seen in a recording, gathered frame by frame."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from cohelm.evaluation.watching import Seen, Tracks
from cohelm.maps import OccupancyGrid
from cohelm.messages import RiderProfile
from cohelm.perception import Predictor
from cohelm.pictures.film import INTERVAL
from cohelm.pictures.people import PeopleMoment, PeopleRecord, draw_people
from cohelm.pictures.people_film import animate_people
from cohelm.recordings import Labels
from cohelm.social import SocialModel

_Kept = tuple[Seen, Labels | None]


class Filming:
    """Keeps the instants that a picture and a film need.

    Args:
        predictor, social_model: that give everyone their space.
        grid: the map, where there is one.
        at: the picture's instant since the first frame, s; None: the first with the most people.
        moving: whether there will be a film.
    """

    def __init__(
        self,
        predictor: Predictor,
        social_model: SocialModel,
        *,
        grid: OccupancyGrid | None = None,
        at: float | None = None,
        moving: bool = False,
    ) -> None:
        self._predictor = predictor
        self._social = social_model
        self._grid = grid
        self._at = at
        self._moving = moving
        self._begin = math.nan
        self._chosen: _Kept | None = None
        self._film: list[_Kept] = []
        self._slot: int | None = None

    def add(self, seen: Seen, labels: Labels | None) -> None:
        """One more frame, and where people truly were, if anybody said."""
        time = seen.observation.time
        self._begin = time if math.isnan(self._begin) else self._begin
        if self._chosen is None or self._rank(seen) > self._rank(self._chosen[0]):
            self._chosen = seen, labels
        if self._moving:
            slot = math.floor((time - self._begin) / INTERVAL + 1e-6)
            if slot != self._slot:
                self._film.append((seen, labels))
            self._slot = slot

    def draw(self, tracks: Tracks, file: Path, title: str) -> None:
        """Write the picture.

        Raises:
            ConfigError: if it cannot be written.
        """
        if self._chosen is not None:
            moment = self._moment(self._chosen)
            since = moment.observation.time - tracks.begin
            n = len(moment.people)
            says = f"{title}: {n} {'person' if n == 1 else 'people'} at {since:.1f} s"
            draw_people(self._record(tracks), moment, file, says)

    def animate(self, tracks: Tracks, file: Path, title: str) -> None:
        """Write the film.

        Raises:
            ConfigError: if it cannot be written.
        """
        animate_people(self._record(tracks), [self._moment(k) for k in self._film], file, title)

    def _rank(self, seen: Seen) -> tuple[float, float]:
        if self._at is not None:
            return -abs(seen.observation.time - self._begin - self._at), 0.0
        perceived = seen.perceived
        return float(len(perceived.people)), float(len(perceived.groups.id))

    def _record(self, tracks: Tracks) -> PeopleRecord:
        return PeopleRecord(begin=tracks.begin, trails=tracks.trails, grid=self._grid)

    def _moment(self, kept: _Kept) -> PeopleMoment:
        seen, labels = kept
        perceived = seen.perceived
        people, groups = perceived.people, perceived.groups
        predictions, _ = self._predictor.predict(people, 1, 0.1, None)
        spaces = self._social.spaces(
            people, groups, predictions, seen.observation.twist, RiderProfile()
        )
        return PeopleMoment(
            observation=seen.observation,
            detections=perceived.detections,
            people=people,
            groups=groups,
            spaces=spaces,
            truth=np.empty((0, 2)) if labels is None else labels.position,
        )
