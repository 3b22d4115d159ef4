"""Pictures of the people in a recording."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from cohelm.errors import ConfigError
from cohelm.messages import Groups, Observation, PointCloud, RiderProfile
from cohelm.perception import ConstantVelocity, Detections
from cohelm.plotting.animation import WIDTH
from cohelm.plotting.charts import CostPanel, draw_costs_against
from cohelm.plotting.people import PeopleMoment, PeopleRecord, draw_people, trails_until
from cohelm.plotting.people_animation import animate_people
from cohelm.social import PersonalSpace
from cohelm.testing.scenes import walkers


def moment(time=0.0, n=3):
    states = np.array([[2.0, 1.0, 1.0, 0.0], [2.0, 2.0, 1.0, 0.0], [4.0, -2.0, 0.0, 0.0]])[:n]
    people = walkers(states + time * np.eye(4)[0], time=time)
    groups = Groups(id=np.array([3]), member=np.array([0, 0, -1])) if n == 3 else Groups.alone(n)
    predictions, _ = ConstantVelocity().predict(people, 1, 0.1, None)
    spaces = PersonalSpace().spaces(people, groups, predictions, np.zeros(3), RiderProfile())
    points = np.array([[2.0, 0.8], [2.1, 0.8], [5.0, 5.0], [5.1, 5.0], [-1.0, 3.0]])
    found = Detections(
        time=time,
        origin=np.zeros(2),
        points=points,
        detection_of_return=[0, 0, -1, -1, -1],
        mapped=np.zeros(5, dtype=bool),
        free_ends=np.empty((0, 2)),
        position=[[2.0, 1.0]],
        radius=[0.25],
        deviation=[0.05],
        confidence=[0.9],
        cluster_of_return=[0, 0, 1, 1, -1],
        ellipse=[[2.0, 1.0, 0.2, 0.1, 0.0], [5.0, 5.0, 0.2, 0.1, 0.0]],
    )
    cloud = PointCloud(
        time=time,
        mount=np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        points=np.array([[1.0, 2.0, 0.0], [np.nan] * 3], dtype=np.float32),
        range_max=10.0,
    )
    return PeopleMoment(
        observation=Observation(
            time=time, pose=np.zeros(3), pose_time=time, twist=np.zeros(3), twist_time=time,
            clouds=(cloud,),
        ),
        detections=(found,), people=people, groups=groups, spaces=spaces,
        truth=np.array([[2.0, 1.1]]),
    )  # fmt: skip


@pytest.fixture
def record():
    times = np.linspace(0.0, 2.0, 21)
    trail = np.stack([times, 2.0 + times, np.ones(21)], axis=-1)
    return PeopleRecord(begin=0.0, trails={4: trail, 11: trail + np.array([0.0, 0.0, 1.0])})


def test_the_same_instant_gives_the_same_bytes(record, tmp_path):
    for name in ("a.png", "b.png"):
        draw_people(record, moment(), tmp_path / name, "who")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as image:
        assert min(image.size) > 300


def test_nobody_and_nothing(tmp_path):
    empty = dataclasses.replace(
        moment(n=0), detections=(Detections.empty(0.0, np.zeros(2)),), truth=np.empty((0, 2))
    )
    draw_people(PeopleRecord(begin=0.0, trails={}), empty, tmp_path / "nobody.svg")
    draw_people(
        PeopleRecord(begin=0.0, trails={}),
        dataclasses.replace(empty, detections=(), spaces=None),
        tmp_path / "blind.png",
    )


def test_a_film_has_a_frame_for_each_instant(record, tmp_path):
    animate_people(record, [moment(t, 3) for t in (0.0, 0.25, 0.5)], tmp_path / "film.gif", "who")
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
        assert film.size[0] == WIDTH


def test_a_wrong_suffix_is_refused(record, tmp_path):
    with pytest.raises(ConfigError, match="--plot"):
        draw_people(record, moment(), tmp_path / "a.bmp")
    with pytest.raises(ConfigError, match="--animate"):
        animate_people(record, [moment()], tmp_path / "a.png")


def test_trails_are_cut_to_the_last_seconds(record):
    cut = dict(trails_until(record, 1.0, 0.5))
    assert cut[4][:, 0].min() == pytest.approx(0.5)
    assert cut[4][:, 0].max() == pytest.approx(1.0)
    assert trails_until(record, 9.0, 0.5) == []


def test_costs_are_drawn(tmp_path):
    costs = np.array([[0.0, 1.0, 2.0], [10.0, 2.0, 3.0]])
    panels = [
        CostPanel("of points", "points", costs, 12.0, 10.0),
        CostPanel("of people", "n", costs),
    ]
    draw_costs_against(panels, tmp_path / "costs.png")
    assert (tmp_path / "costs.png").stat().st_size > 5000
