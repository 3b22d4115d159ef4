"""Perception on a recording: parts, frames and summary."""

import numpy as np
import pytest

from cohelm.errors import ConfigError, PluginError
from cohelm.evaluation.perception.recording_view import (
    DETECTION_PARTS,
    NO_MAP,
    RecordingSummary,
    frame_record,
    parts_of,
    perceive_frames,
    perception_of,
)
from cohelm.messages import Groups, Sensing
from cohelm.recordings import Frame
from cohelm.scenarios.scenario import PARTS

from .frames import seen


def test_the_parts_are_those_of_a_scenario():
    parts = parts_of(())
    assert tuple(parts) == DETECTION_PARTS
    from cohelm import plugins

    assert all(isinstance(parts[key], plugins.load(*PARTS[key])) for key in DETECTION_PARTS)


def test_a_setting_reaches_a_part():
    assert perception_of(["detector.min_samples=4"]).detector.parameters.min_samples == 4
    assert type(perception_of(["tracker.use=given"]).tracker).__name__ == "GivenPeople"


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("trakcer.gate=3", "did you mean 'tracker'"),
        ("rider.use=none", "no such part"),
        ("tracker=kalman", "tracker.use=NAME"),
        ("tracker", "tracker.use=NAME"),
        ("detector.min_sample=4", "did you mean 'min_samples'"),
    ],
)
def test_a_setting_that_reaches_nothing_is_refused(setting, says):
    with pytest.raises(ConfigError, match=says):
        parts_of([setting])
    with pytest.raises(PluginError):
        parts_of(["tracker.use=nobody"])


def test_without_a_map_walls_are_far():
    assert NO_MAP.at(np.array([[0.0, 0.0], [1e6, -1e6]])).min() > 1e5


def test_a_frame_without_readings_is_silent():
    observation = seen(1.0).observation
    (found,) = perceive_frames([Frame(observation=observation)], perception_of())
    silent = {"t": 1.0, "sensing": "silent", "pose": [0.0, 0.0, 0.0], "people": []}
    assert frame_record(found) == silent


def test_what_is_said_of_a_person():
    pair = Groups(id=np.array([9]), member=np.array([0, -1]))
    said = frame_record(seen(2.5, [[1.0, 2.0, 0.5, 0.0], [3.0, 4.0, 0.0, 0.0]], groups=pair))
    first, second = said["people"]
    assert set(first) == {"id", "x", "y", "vx", "vy", "confidence", "group"}
    assert (first["x"], first["vx"], first["group"]) == (1.0, 0.5, 9)
    assert second["group"] is None


def test_what_a_recording_comes_to():
    tracks = RecordingSummary()
    for k in range(41):  # person 0 goes on as 5 after 2.5 s, person 9 is there for an instant
        who = 0 if k < 25 else 5
        place = [0.1 * k, 1.0, 1.0, 0.0]
        extra = [[8.0, 8.0, 0.0, 0.0]] if k == 3 else []
        tracks.add(seen(k / 10, [place, *extra], ids=[who] + [9] * len(extra)))
    assert tracks.frames == 41
    assert tracks.end - tracks.begin == pytest.approx(4.0)
    assert tracks.max_people == 2
    assert tracks.lasting() == [0]
    assert sorted(tracks.trails) == [0, 5, 9]
    assert tracks.switched_ids() == 1
    assert tracks.sensing == {Sensing.OK: 41}


def test_two_who_walk_at_once_do_not_take_over_from_each_other():
    tracks = RecordingSummary()
    for k in range(30):
        tracks.add(seen(k / 10, [[0.1 * k, 0.0, 1, 0], [0.1 * k, 0.5, 1, 0]], ids=[1, 2]))
    assert tracks.switched_ids() == 0
