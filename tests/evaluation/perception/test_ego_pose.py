"""Recordings of a moving sensor without poses."""

import json

import numpy as np
import pytest
from tests.evaluation.perception.frames import seen
from tests.perception.driven import furnished
from tests.perception.rays import observation
from tests.recordings.bags import ROS1, write

from cohelm.cli.app import status
from cohelm.evaluation.perception.ego_motion import MatchStatus
from cohelm.evaluation.perception.ego_pose import EgoPathSummary, EgoPoses, PoseSource
from cohelm.evaluation.perception.recording_view import (
    Ids,
    RecordingSummary,
    perceive_frames,
    perception_of,
)
from cohelm.geometry import transform
from cohelm.messages import Groups, PointCloud
from cohelm.recordings import Frame, Labels, open_recording

START = np.array([-4.0, 0.0, 0.0])


def where(time):
    return START + np.array([0.6 * time, 0.0, 0.3 * np.sin(0.8 * time)])


def person(time):
    """Two legs that walk at 0.8 m/s towards −x, past the scanner's left."""
    x, stride = 4.5 - 0.8 * time, 0.05 + 0.2 * abs(np.sin(5.0 * time))
    return np.array([[x - stride, 1.0, 0.06], [x + stride, 1.0, 0.06]])


def write_bag(file, seconds=9.0, people=False, frame="laser"):
    """A scanner driven through a furnished room at 10 Hz, and not a word of where it was."""
    laser, discs = furnished()
    messages = []
    for k in range(round(10 * seconds)):
        time = 0.1 * k
        there = np.concatenate([discs, person(time)]) if people else discs
        scan, _ = laser.scan(time, where(time), there)
        about = {
            "angle_min": scan.angle_min, "angle_max": np.pi, "range_max": scan.range_max,
            "angle_increment": scan.angle_increment,
        }  # fmt: skip
        message = ROS1.scan(100.0 + time, scan.ranges, frame, **about)
        messages.append(("/scan", 100.0 + time, message))
    return write(file, messages)


@pytest.fixture(scope="module")
def empty_room(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("driven") / "empty.bag")


@pytest.fixture(scope="module")
def with_a_person(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("driven") / "walk.bag", people=True)


def told(capsys, *arguments):
    assert status(["people", *map(str, arguments), "--json"]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_where_nobody_is_nobody_is_told(capsys, empty_room):
    frames = told(capsys, empty_room)
    assert sum(len(frame["people"]) for frame in frames) == 0
    assert frames[-1]["pose"] == pytest.approx(where(8.9) - START, abs=0.03)


def test_taken_as_at_rest_its_furniture_walks(capsys, empty_room):
    frames = told(capsys, empty_room, "--still")
    assert sum(len(frame["people"]) for frame in frames) > 100
    assert all(frame["pose"] == [0.0, 0.0, 0.0] for frame in frames)


def test_who_walks_is_told_with_a_velocity_over_the_ground(capsys, with_a_person):
    frames = told(capsys, with_a_person)
    errors = []
    for frame in frames[20:80]:
        time = frame["t"] - 100.0
        truth = person(time)[:, :2].mean(axis=0) - START[:2]
        assert len(frame["people"]) <= 1
        errors += [
            (each["x"] - truth[0], each["y"] - truth[1], each["vx"] + 0.8, each["vy"])
            for each in frame["people"]
        ]
    assert len(errors) >= 45
    off = np.abs(errors)
    assert np.hypot(off[:, 0], off[:, 1]).mean() < 0.1
    assert np.hypot(off[:, 2], off[:, 3]).mean() < 0.25


def test_the_table_says_whose_way_it_was(capsys, empty_room):
    for arguments, says in (
        ([], "m, estimated from its readings"),
        (["--still"], "assumed at rest"),
    ):
        assert status(["people", str(empty_room), "--seconds", "2", *arguments]) == 0
        out, err = capsys.readouterr()
        assert says in " ".join(out.split())
        assert "no pose of 'laser'" in err


def test_a_found_pose_is_as_good_as_a_known_one(empty_room):
    found = list(perceive_frames(open_recording(empty_room), perception_of()))
    known = []
    for each in open_recording(empty_room):
        pose = where(each.observation.time - 100.0) - START
        known.append(Frame(observation=_at(each.observation, pose)))
    told_of_known = sum(
        len(each.perceived.people) for each in perceive_frames(known, perception_of())
    )
    assert sum(len(each.perceived.people) for each in found) <= told_of_known
    assert {each.source for each in found} == {PoseSource.ESTIMATED}


def _at(given, pose):
    return observation(given.time, pose, scans=given.scans)


def test_what_the_recording_says_is_believed():
    frame = Frame(observation=observation(1.0, (1.0, 2.0, 3.0)))
    placed = EgoPoses()(frame)
    assert placed.frame is frame
    assert (placed.source, placed.ego_motion) == (PoseSource.RECORDED, None)


def test_labels_go_along():
    laser, discs = furnished()
    own_way, label = EgoPoses(), np.array([[1.0, 0.5]])
    for k in range(5):
        pose = (0.2 * k, 0.0, 0.0)
        scan, _ = laser.scan(0.1 * k, pose, discs)
        labels = Labels(time=0.1 * k, position=label, id=np.array([-1]), visible=np.ones(1))
        frame = Frame(observation=observation(0.1 * k, scans=(scan,)), labels=labels, posed=False)
        placed = own_way(frame)
        found = placed.frame.observation.pose
        assert found == pytest.approx(pose, abs=0.02)
        assert placed.frame.labels.position == pytest.approx(transform(found, label))


def test_two_sensors_of_which_nothing_is_known_have_a_way_each():
    laser, discs = furnished()
    own_way, nothing = EgoPoses(), np.empty((0, 3), dtype=np.float32)
    for k in range(6):
        scan, _ = laser.scan(0.1 * k, (0.2 * k, 0.0, 0.0), discs)
        cloud = PointCloud(time=0.1 * k, mount=np.zeros(6), points=nothing, range_max=10.0)
        driven = own_way(Frame(observation=observation(0.1 * k, scans=(scan,)), posed=False))
        blind = own_way(Frame(observation=observation(0.1 * k, clouds=(cloud,)), posed=False))
    assert driven.ego_motion.pose == pytest.approx([1.0, 0.0, 0.0], abs=0.02)
    assert (blind.ego_motion.pose == 0.0).all()
    assert blind.ego_motion.status is MatchStatus.HELD


def test_ids_are_never_told_again():
    ids = Ids()
    pair = Groups(id=np.array([3]), member=np.array([0, 0]))
    first = ids(seen(0.0, np.zeros((2, 4)), ids=[0, 5], groups=pair).perceived)
    assert first.people.id.tolist() == [0, 5]
    ids.start_part()
    second = ids(seen(1.0, np.zeros((2, 4)), ids=[0, 1], groups=pair).perceived)
    assert second.people.id.tolist() == [6, 7]
    assert second.groups.id.tolist() == [9]


def test_where_readings_fit_no_more_all_begin_anew():
    laser, discs = furnished()
    frames = []
    for k in range(60):
        pose = (0.0, 0.0, 0.0) if k < 30 else (1.0, 0.0, 2.0)
        scan, _ = laser.scan(0.1 * k, pose, np.concatenate([discs, person(0.1 * k + 3.0)]))
        frames.append(Frame(observation=observation(0.1 * k, scans=(scan,)), posed=False))
    told_ids, tracks = [], RecordingSummary()
    for each in perceive_frames(frames, perception_of()):
        tracks.add(each)
        told_ids.append(set(each.perceived.people.id.tolist()))
    before, after = set().union(*told_ids[:30]), set().union(*told_ids[40:])
    assert before
    assert after
    assert not before & after
    assert tracks.ego_path.restarts == 1
    assert "restarted" in str(tracks.ego_path)


def test_nothing_travelled_is_what_the_recording_says():
    assert str(EgoPathSummary()) == "recorded"
