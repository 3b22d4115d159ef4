"""A damaged file gives frames or a ``RecordingError``."""

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.messages import Observation
from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, write
from .clouds import pcd


def everything(author):
    """A bag with all that is read."""
    still = (0.0, 0.0, 0.0)
    moved = author.transforms(
        (1.0, "map", "odom", still, still), (1.0, "odom", "base_link", still, still)
    )
    held = author.transforms((0.0, "base_link", "laser", (0.3, 0.0, 0.2), still))
    messages = [("/tf_static", 1.0, held), ("/tf", 1.0, moved)]
    for k in range(3):
        t = 1.0 + 0.1 * k
        messages += [
            ("/odom", t, author.odometry(t, (0.1 * k, 0.0, 0.0), (1.0, 0.0, 0.0))),
            ("/leg_cluster_positions", t, author.poses(0.0, [(1.0, 0.0)])),
            ("/scan", t, author.scan(t, [1.0, 2.0, 3.0])),
            ("/points", t, author.plain_cloud(t, [[1, 2, 3], [4, 5, 6]])),
        ]
    return messages


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a sound file of each kind, by its name."""
    folder = tmp_path_factory.mktemp("whole")
    points = np.arange(90.0).reshape(30, 3)
    files = {
        f"{encoding}.pcd": pcd(points, encoding, "xyzi")
        for encoding in ("ascii", "binary", "binary_compressed")
    }
    files["kitti.bin"] = np.tile(np.arange(4.0, dtype="<f4"), 30).tobytes()
    files["nuscenes.pcd.bin"] = np.tile(np.arange(5.0, dtype="<f4"), 30).tobytes()
    for compression in (None, "BZ2", "LZ4"):
        file = write(folder / f"{compression}.bag", everything(ROS1), "bag", compression)
        files[file.name] = file.read_bytes()
    for kind, compression in (("mcap", None), ("mcap", "STORAGE"), ("db3", None)):
        path = write(folder / f"{kind}{compression}", everything(ROS2), kind, compression)
        files[f"{compression}.{kind}"] = (path / f"{path.name}.{kind}").read_bytes()
    return files


NAMES = [
    "ascii.pcd", "binary.pcd", "binary_compressed.pcd", "kitti.bin", "nuscenes.pcd.bin",
    "None.bag", "BZ2.bag", "LZ4.bag", "None.mcap", "STORAGE.mcap", "None.db3",
]  # fmt: skip


def read_whole(name):
    return 6 if name.rpartition(".")[2] in {"bag", "mcap", "db3"} else 1


def read(file):
    """How many frames it gives; anything but a ``RecordingError`` that names it is a failure."""
    count, said = 0, []
    try:
        recording = open_recording(file)
        said = recording.warnings
        for frame in recording:
            count += 1
            seen = frame.observation
            assert isinstance(seen, Observation)
            assert np.isfinite([seen.time, *seen.pose, *seen.twist]).all()
    except RecordingError as error:
        said.append(str(error))
    assert all(file.name in text for text in said)
    return count


@pytest.mark.parametrize("name", NAMES)
def test_a_sound_file_gives_its_frames_without_a_warning(whole, tmp_path, name):
    file = tmp_path / name
    file.write_bytes(whole[name])
    assert read(file) == read_whole(name)
    assert open_recording(file).warnings == []


@pytest.mark.parametrize("name", NAMES)
def test_cut_anywhere_it_gives_frames_or_says_why_not(whole, tmp_path, name, rng):
    data, file = whole[name], tmp_path / name
    for length in rng.integers(0, len(data), 12):
        file.write_bytes(data[:length])
        assert read(file) <= read_whole(name)


@pytest.mark.parametrize("name", NAMES)
def test_with_any_bytes_changed_it_gives_frames_or_says_why_not(whole, tmp_path, name, rng):
    for _ in range(25):
        data = bytearray(whole[name])
        for at in rng.integers(0, len(data), rng.integers(1, 12)):
            data[at] = rng.choice([0, 1, 127, 255, rng.integers(256)])
        file = tmp_path / name
        file.write_bytes(data)
        read(file)
