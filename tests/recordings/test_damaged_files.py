"""A damaged file gives frames or a ``RecordingError``."""

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.messages import Observation
from cohelm.recordings import open_recording

from .sound_files import NAMES, sound_files


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a sound file of each kind, by its name."""
    return sound_files(tmp_path_factory.mktemp("whole"))


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
