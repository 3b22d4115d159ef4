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
@pytest.mark.parametrize("metadata", [True, False])
def test_a_file_and_its_compressed_copy_are_read_once(tmp_path, kind, metadata):
    bag = packed(tmp_path, kind)
    (bag / f"bag.{kind}").write_bytes(plain(tmp_path, kind).read_bytes())
    if not metadata:
        (bag / "metadata.yaml").unlink()
    recording = open_recording(bag)
    assert recording.frames == len(list(recording)) == 5
    # The metadata name the compressed one.
    left = f"bag.{kind}" if metadata else f"bag.{kind}.zstd"
    assert any(text.endswith(left) and "not read" in text for text in recording.warnings)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize("unpacked", [True, False])
def test_a_file_that_was_unpacked_or_packed_after_its_metadata_is_read(tmp_path, kind, unpacked):
    if unpacked:
        bag = packed(tmp_path, kind)
        (bag / f"bag.{kind}.zstd").unlink()
        (bag / f"bag.{kind}").write_bytes(plain(tmp_path, kind).read_bytes())
    else:
        bag = write(tmp_path / "bag", walk(ROS2), kind)
        (bag / f"bag.{kind}").unlink()
        whole = packed(tmp_path / "other", kind) / f"bag.{kind}.zstd"
        whole.rename(bag / whole.name)
    recording = open_recording(bag)
    assert len(list(recording)) == 5
    assert not any("missing" in text for text in recording.warnings)


def packed(folder, kind):
    """A bag whose file of messages is compressed as a whole."""
    zstd = pytest.importorskip("backports.zstd")
    bag = write(folder / "bag", walk(ROS2), kind)
    file, about = bag / f"bag.{kind}", bag / "metadata.yaml"
    (bag / f"{file.name}.zstd").write_bytes(zstd.compress(file.read_bytes()))
    file.unlink()
    about.write_text(about.read_text().replace(file.name, f"{file.name}.zstd"))
    return bag


def plain(folder, kind):
    return write(folder / "plain", walk(ROS2), kind) / f"plain.{kind}"


def test_the_parts_of_a_ros_1_bag_are_read_in_their_order(tmp_path):
    messages = walk(ROS1, count=12)
    for k in range(12):
        name = f"walk_{k}.bag.active" if k == 11 else f"walk_{k}.bag"
        write(tmp_path / name, messages[k : k + 1])
    recording = open_recording(tmp_path)
    assert recording.frames == 12
    times = [frame.observation.time for frame in recording]
    assert times == pytest.approx([50.0 + 0.1 * k for k in range(12)])
    assert any("12 bags are read one after the other" in text for text in recording.warnings)
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
