"""Instants collected for the picture and the film of a recording."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from cohelm.evaluation.perception.film import FILMED, FilmRecorder
from cohelm.evaluation.perception.recording_view import LASTING, RecordingSummary
from cohelm.messages import PointCloud
from cohelm.perception import ConstantVelocity
from cohelm.plotting.people import BACKDROP, thinned
from cohelm.social import PersonalSpace

from .frames import seen

HERE, THERE = [3.0, 0.0, 0.0, 0.0], [0.0, 4.0, 0.0, 0.0]


class Counting(ConstantVelocity):
    """Remembers by its memory, and tells, how often it was asked before."""

    def predict(self, people, steps, step, memory):
        told, _ = super().predict(people, steps, step, None)
        return told, (memory or 0) + 1


class Noting(PersonalSpace):
    """Keeps what it was given."""

    def __init__(self):
        super().__init__()
        self.given = []

    def spaces(self, people, groups, predictions, twist, profile):
        self.given.append(people.time)
        return super().spaces(people, groups, predictions, twist, profile)


def with_cloud(frame, points):
    cloud = PointCloud(
        time=frame.observation.time,
        mount=np.zeros(6),
        points=np.tile(np.arange(points, dtype=np.float32)[:, None], (1, 3)),
        range_max=10.0,
    )
    observation = dataclasses.replace(frame.observation, clouds=(cloud,))
    return dataclasses.replace(frame, observation=observation)


def filming(**options):
    return FilmRecorder(ConstantVelocity(), PersonalSpace(), **options)


def test_the_instant_asked_for_counts_from_where_the_recording_begins():
    # shown from 110 s on of a recording that begins at 100 s: "at 12" is 112 s, not 122 s
    film = filming(at=12.0, begin=100.0)
    for k in range(40):
        film.add(seen(110.0 + k / 2, [HERE]), None)
    assert film.at == 12.0


def test_without_a_beginning_instants_count_from_the_first_frame():
    film = filming(at=12.0)
    assert np.isnan(film.at)
    for k in range(40):
        film.add(seen(110.0 + k / 2, [HERE]), None)
    assert film.at == 12.0


def test_the_busiest_instant_is_that_of_people_who_stay():
    film = filming()
    for k in range(30):
        there = [(0, HERE), *([(1, THERE)] if k > 8 else [])]
        there += [(7 + i, [6.0, i, 0.0, 0.0]) for i in range(3)] if k == 5 else []
        ids, people = zip(*there, strict=True)
        film.add(seen(k / 10, people, ids=ids), None)
    # the second has been there for LASTING from 0.9 s + 2 s on; the three flashes never were
    assert film.at == pytest.approx(0.9 + LASTING)


def test_a_film_keeps_no_more_of_a_cloud_than_it_shows(tmp_path):
    film = filming(moving=True)
    tracks = RecordingSummary()
    for k in range(10):
        frame = with_cloud(seen(k / 10, [HERE]), 4 * FILMED + 1)
        tracks.add(frame)
        film.add(frame, None)
    kept = [moment.observation.clouds[0].points for moment in film._film]
    assert len(kept) == 4  # 0.0, 0.3, 0.5, 0.8 s: one every 0.25 s
    for points in kept:
        assert FILMED / 2 < len(points) <= FILMED
        assert points.base is None  # else all of the cloud lives on
    film.animate(tracks, tmp_path / "film.gif", "who")
    with Image.open(tmp_path / "film.gif") as image:
        assert image.n_frames == 4


@pytest.mark.parametrize("points", [0, 1, 5, 6, 7, 100])
def test_points_are_left_out_evenly(points):
    thin = thinned(with_cloud(seen(0.0), points).observation, 6).clouds[0].points[:, 0]
    assert len(thin) <= 6
    assert len(thin) > min(points, 6) / 2 - 1
    assert len(np.unique(np.diff(thin))) <= 1
    assert BACKDROP >= FILMED


def test_the_predictor_remembers_from_frame_to_frame():
    predictor, spaces = Counting(), Noting()
    film = FilmRecorder(predictor, spaces, at=0.9)
    for k in range(10):
        film.add(seen(k / 10, [HERE]), None)
    assert film._memory == 10
    assert spaces.given[-1] == pytest.approx(0.9)
