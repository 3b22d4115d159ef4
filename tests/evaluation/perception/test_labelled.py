"""Tracked people against labels: shares, errors, identities, and files of labels."""

import json
import math

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.evaluation.perception.labelled import (
    REACH,
    LabelledInstants,
    LabelScoring,
    RecordingLabels,
    read_label_source,
)
from cohelm.evaluation.perception.tracking_scores import FrameMatch, identities

from .frames import labels, seen

HERE = [3.0, 0.0, 0.0, 0.0]


def scores(frames, truth=None):
    scoring = LabelScoring(truth or RecordingLabels())
    for each in frames:
        scoring(each)
    return scoring.scores()


def test_two_legs_are_found_with_one_person_and_somebody_else_has_no_label():
    frame = seen(0.0, [HERE, [6.0, 2.0, 0.0, 0.0]], labels=labels(0.0, [[3.0, 0.2], [3.0, -0.4]]))
    found = scores([frame])
    assert found.labels == 2
    assert found.found == 1.0
    assert found.error == pytest.approx((0.2 + 0.4) / 2)
    assert found.unlabelled == found.unlabelled_most == 1
    assert found.identities is None


def test_a_label_that_nobody_is_told_at_lowers_the_share():
    there = labels(0.0, [[3.0, 0.0], [0.0, 5.0]])
    found = scores([seen(0.0, [HERE], labels=there), seen(0.1, [HERE], labels=there)])
    assert found.found == 0.5
    assert found.instants == 2
    assert found.unlabelled == 0.0


def test_labels_too_far_or_hidden_are_left_out_and_so_is_whoever_is_told_there():
    far = labels(0.0, [[REACH + 0.2, 0.0]])
    hidden = labels(0.1, [[3.0, 0.0]], visible=0.2)
    found = scores([
        seen(0.0, [[REACH, 0.0, 0.0, 0.0]], labels=far), seen(0.1, [HERE], labels=hidden)
    ])  # fmt: skip
    assert (found.labels, found.left_out, found.unlabelled) == (0, 2, 0.0)
    assert math.isnan(found.found)


def test_nothing_to_compare_has_no_share():
    found = scores([seen(0.0, [HERE])])
    assert found.instants == 0
    assert math.isnan(found.found)
    assert math.isnan(found.unlabelled)


def test_an_id_that_changes_halfway_is_one_change_and_half_the_identity():
    frames = [
        seen(k / 10, [HERE], ids=[7 if k < 5 else 8], labels=labels(k / 10, [[3.0, 0.0]], [1]))
        for k in range(10)
    ]
    found = scores(frames).identities
    assert found.switches == 1
    assert found.mota == pytest.approx(1.0 - 1 / 10)
    assert found.idf1 == pytest.approx(0.5)  # 5 of 10 told under the id that fits best


def test_identities_of_misses_and_false_ones():
    nobody = np.empty((0, 2)), np.empty(0, dtype=int)
    instants = [
        FrameMatch(true_id=[1], true=[[0.0, 0.0]], tracked_id=[5], tracked=[[0.6, 0.0]]),
        FrameMatch(true_id=[1], true=[[0.0, 0.0]], tracked_id=nobody[1], tracked=nobody[0]),
    ]
    found = identities(instants, within=0.5)
    assert (found.misses, found.false, found.switches, found.positions) == (2, 1, 0, 2)
    assert found.mota == pytest.approx(1 - 3 / 2)


def test_labels_between_frames_meet_the_first_near_one_only_and_people_who_walked_on():
    truth = LabelledInstants([labels(0.05, [[3.1, 0.0]]), labels(5.0, [[9.0, 0.0]])])
    walking = [[3.0, 0.0, 2.0, 0.0]]
    assert truth.at(seen(0.2, walking)) is None
    found = scores([seen(0.0, walking), seen(0.1, walking)], truth)
    assert found.instants == 1
    assert found.error == pytest.approx(0.0, abs=1e-12)  # 0.05 s on at 2 m/s


def test_own_json_lines_are_labels(tmp_path):
    file = tmp_path / "truth.jsonl"
    lines = [
        {"t": 0.0, "people": [{"id": 4, "x": 3.0, "y": 0.0}], "sensing": "ok"},
        {"t": 0.1, "people": []},
        {"scores": {}},
    ]
    file.write_text("\n".join(json.dumps(line) for line in lines) + "\n\n")
    truth = read_label_source(file, tmp_path / "a.bag")
    assert truth.at(seen(0.0)).id.tolist() == [4]
    assert len(truth.at(seen(0.1)).id) == 0
    assert truth.at(seen(0.3)) is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "has no labelled instant"),
        ('{"scores": {}}', "has no labelled instant"),
        ("nonsense", "line 1"),
        ('{"t": 0.0, "people": []}\n{"t": "now", "people": []}', "line 2"),
        ('{"t": 0.0}', "line 1"),
        ('{"t": NaN, "people": []}', "line 1"),
        ('{"t": 0.0, "people": [{"x": 1.0}]}', "line 1"),
        ("[1, 2]", "line 1"),
        ("[" * 100_000, "line 1"),
    ],
)
def test_lines_that_make_no_sense_are_named(tmp_path, text, says):
    file = tmp_path / "truth.json"
    file.write_text(text)
    with pytest.raises(RecordingError, match=says) as refused:
        read_label_source(file, tmp_path / "a.bag")
    assert str(file) in str(refused.value)


def test_walks_begin_with_the_recording(tmp_path):
    file = tmp_path / "obsmat.txt"
    rows = [[frame, 3, 0.1 * frame, 0.0, 2.0, 0.0, 0.0, 0.0] for frame in (0, 10, 20)]
    file.write_text("\n".join(" ".join(map(str, row)) for row in rows))
    truth = read_label_source(file, tmp_path / "a.bag")
    assert truth.at(seen(100.0)).position.tolist() == [[0.0, 2.0]]
    assert truth.at(seen(100.4)).position == pytest.approx(np.array([[1.0, 2.0]]))


def test_walks_begin_with_the_recording_and_not_with_what_is_shown_of_it(tmp_path):
    file = tmp_path / "obsmat.txt"
    rows = [[frame, 3, 0.1 * frame, 0.0, 2.0, 0.0, 0.0, 0.0] for frame in (0, 10, 20)]
    file.write_text("\n".join(" ".join(map(str, row)) for row in rows))
    truth = read_label_source(file, tmp_path / "a.bag", 100.0)
    assert truth.at(seen(100.4)).position == pytest.approx(np.array([[1.0, 2.0]]))
    assert len(truth.at(seen(101.0)).id) == 0  # the walk ended at 0.8 s


def test_identities_are_those_of_filmed_crowds():
    # two are told beside one label: one of them is nobody, as in a filmed crowd
    there = labels(0.0, [[3.0, 0.0]], [1])
    found = scores([seen(0.0, [HERE, [3.0, 0.3, 0.0, 0.0]], labels=there)])
    assert (found.found, found.unlabelled) == (1.0, 0.0)
    assert (found.identities.misses, found.identities.false) == (0, 1)


@pytest.mark.parametrize(
    ("name", "recording", "says"),
    [
        ("nothing.txt", "000000.bin", "no such file"),
        ("nothing.jsonl", "a.bag", "no such file"),
        ("000000.txt", "a.bag", "a.bag"),
    ],
)
def test_a_truth_that_is_missing_or_of_something_else_is_refused(tmp_path, name, recording, says):
    if not name.startswith("nothing"):
        (tmp_path / name).write_text("Pedestrian 0 0 0 0 0 0 0 1.8 0.5 0.5 1 1 8 0\n")
    with pytest.raises(RecordingError, match=says):
        read_label_source(tmp_path / name, tmp_path / recording)
