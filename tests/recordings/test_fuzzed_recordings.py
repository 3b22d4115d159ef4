"""Damaged recordings: thousands of each kind give data, a warning or an error, never a fault.

Three laws hold for every copy. Times never run back without a word, no coordinate is beyond any
sensor without a word, and neither is a number of points or frames that the file does not declare.
A changed number that is as plausible as the old one cannot be detected where a format has no
checksum: PCD, KITTI, ROS 1 bags (their index decides which messages are read), SQLite.
"""

import itertools

import numpy as np
import pytest
from tests.mutated import LONGEST, MOST_MEMORY, PARTS, fuzzed

from .sound_files import NAMES, read_frames, sound_files

FARTHEST = 1e4
"""Coordinate beyond any sensor, m."""
FARTHEST_POSE = 1e7
"""Coordinate beyond any map, m."""
CHECKED = {"checked.mcap"}
"""Files with a checksum over all messages."""


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return sound_files(tmp_path_factory.mktemp("sound"))


def readings(seen):
    """All readings of one observation."""
    points = [cloud.points.ravel() for cloud in seen.clouds]
    ranges = [scan.ranges for scan in seen.scans]
    with np.errstate(invalid="ignore"):
        return np.concatenate([*points, *ranges]).astype(float)


def everything(seen):
    """All numbers of one observation."""
    return np.concatenate([[seen.time], seen.pose, seen.twist, readings(seen)])


def difference(sound, frames):
    """``time``, ``far``, ``count`` or ``number``: the broken law, or a changed value."""
    times = [seen.time for seen in frames]
    if any(b < a for a, b in itertools.pairwise(times)):
        return "time"
    numbers = [readings(seen) for seen in frames]
    if any((np.abs(each[np.isfinite(each)]) > FARTHEST).any() for each in numbers):
        return "far"
    if any(np.abs([*seen.pose, *seen.twist]).max() > FARTHEST_POSE for seen in frames):
        return "far"
    if [len(each) for each in numbers] != [len(readings(seen)) for seen in sound]:
        return "count"
    same = all(
        np.array_equal(a, b, equal_nan=True)
        for a, b in zip(map(everything, frames), map(everything, sound), strict=True)
    )
    return "" if same else "number"


@pytest.mark.parametrize("name", NAMES)
def test_a_sound_recording_gives_all_its_frames_without_a_warning(sound, tmp_path, name):
    (tmp_path / name).write_bytes(sound[name])
    frames, warnings = read_frames(tmp_path / name)
    assert (len(frames), warnings) == (6 if name.endswith(("bag", "mcap", "db3")) else 1, [])


@pytest.mark.parametrize("copies", PARTS)
@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_recording_is_read_or_refused_and_its_damage_is_said(
    sound, tmp_path, name, copies
):
    tally = fuzzed(
        tmp_path / name, sound[name], read_frames,
        copies=copies, seed=1, difference=difference,
    )  # fmt: skip
    broken = [
        (number, what)
        for number, what in tally.silent
        if name in CHECKED or what in {"time", "far"} or (what == "count" and name.endswith(".pcd"))
    ]
    assert "not one line" not in tally.counts
    assert not broken, (str(tally), broken)
    assert tally.slowest < LONGEST
    assert tally.memory < MOST_MEMORY
