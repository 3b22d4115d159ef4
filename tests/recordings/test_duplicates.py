"""Topics that repeat another one, and copies of files of messages."""

import numpy as np
import pytest

from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, walk, write

START = 1.7e9


def twice(second, frame="laser", every=1, later=0.0, **changed):
    """Scans on /scan, and on another topic with the same stamps."""
    messages = []
    for k in range(20):
        t = START + 0.1 * k
        messages.append(("/scan", t, ROS2.scan(t, [1.0, 2.0, 3.0, 4.0, 5.0])))
        if k % every == 0:
            scan = ROS2.scan(t + later, [np.nan, 2.0, 3.0, 4.0, 5.0], frame, **changed)
            messages.append((second, t + 0.002, scan))
    return messages


@pytest.mark.parametrize("second", ["/scan_filtered", "/a/scan", "/robot/scan_throttled"])
@pytest.mark.parametrize("every", [1, 4])
@pytest.mark.parametrize("changed", [{}, {"angle_min": -0.25, "angle_max": 0.25}], ids=str)
def test_the_same_scanner_on_two_topics_is_read_once(tmp_path, second, every, changed):
    file = write(tmp_path / "a", twice(second, every=every, **changed), "mcap")
    recording = open_recording(file)
    frames = list(recording)
    assert recording.frames == len(frames) == 20
    assert {frame.observation.scans[0].ranges[0] for frame in frames} == {1.0}
    (text,) = [text for text in recording.warnings if "repeats" in text]
    assert f"{second} repeats /scan" in text
    chosen = open_recording(file, topic=second)
    assert len(list(chosen)) == 20 // every
    assert not any("repeats" in text for text in chosen.warnings)


@pytest.mark.parametrize(
    "other",
    [
        {"frame": "laser_2"},
        {"later": 0.03},
        {"angle_min": 1.0, "angle_max": 2.0},  # it looks elsewhere
    ],
    ids=str,
)
def test_two_scanners_are_both_read(tmp_path, other):
    recording = open_recording(write(tmp_path / "a", twice("/scan_2", **other), "mcap"))
    assert len(list(recording)) == 40
    assert not any("repeats" in text for text in recording.warnings)


def test_a_part_of_a_cloud_is_not_read_beside_the_whole(tmp_path):
    points = np.arange(30.0).reshape(10, 3)
    messages = []
    for k in range(5):
        t = START + 0.1 * k
        messages.append(("/ground", t, ROS2.plain_cloud(t, points[:4])))
        messages.append(("/points", t, ROS2.plain_cloud(t, points)))
    recording = open_recording(write(tmp_path / "a", messages, "mcap"))
    assert {len(frame.observation.clouds[0].points) for frame in recording} == {10}
    assert any("/ground repeats /points" in text for text in recording.warnings)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_a_compressed_file_is_read_and_beside_a_plain_copy_only_once(tmp_path, kind):
    zstd = pytest.importorskip("backports.zstd")
    bag = write(tmp_path / "bag", walk(ROS2), kind)
    (bag / "metadata.yaml").unlink()
    file = bag / f"bag.{kind}"
    (bag / f"{file.name}.zstd").write_bytes(zstd.compress(file.read_bytes()))
    assert len(list(open_recording(bag))) == 5
    file.unlink()
    assert len(list(open_recording(bag))) == 5


def test_the_parts_of_a_ros_1_bag_are_read_in_their_order(tmp_path):
    messages = walk(ROS1, count=12)
    for k in range(12):
        name = f"walk_{k}.bag.active" if k == 11 else f"walk_{k}.bag"
        write(tmp_path / name, messages[k : k + 1])
    recording = open_recording(tmp_path)
    assert recording.frames == 12
    times = [frame.observation.time for frame in recording]
    assert times == pytest.approx([50.0 + 0.1 * k for k in range(12)])
    assert any("12 files are read one after the other" in text for text in recording.warnings)
    # A part that is empty or damaged costs only itself.
    (tmp_path / "walk_3.bag").write_bytes(b"")
    recording = open_recording(tmp_path)
    assert len(list(recording)) == 11
    assert any("walk_3.bag" in text for text in recording.warnings)


def test_transforms_in_one_part_hold_in_the_others(tmp_path):
    first = ROS1.transforms((50.0, "odom", "laser", (3.0, 4.0, 0.0), (0.0, 0.0, 0.5)))
    write(tmp_path / "a_0.bag", [("/tf", 100.0, first)])
    write(tmp_path / "a_1.bag", walk(ROS1))
    frames = list(open_recording(tmp_path))
    assert len(frames) == 5
    assert frames[0].observation.pose == pytest.approx([3.0, 4.0, 0.5])
