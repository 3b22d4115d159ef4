"""Open any recording: its kind is recognised by its first bytes, else by its name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.api import SensorRecording, natural_order
from cohelm.recordings.bags.bag_recording import BagRecording
from cohelm.recordings.bags.files import is_bag, message_files
from cohelm.recordings.clouds.kitti import read_kitti
from cohelm.recordings.clouds.nuscenes import has_rings, read_nuscenes
from cohelm.recordings.clouds.pcd import looks_like_pcd, read_pcd
from cohelm.recordings.clouds.sweep import CloudSweep, SweepRecording

RATE = 10.0
"""Sweep rate of a folder without times, that of KITTI's Velodyne, Hz."""

KNOWN = (
    "known are ROS 1 bags (.bag), ROS 2 bags (a folder with metadata.yaml, .mcap, .db3), "
    "KITTI (.bin), nuScenes (.pcd.bin), PCD (.pcd), and folders of .bag files or of these sweeps"
)

_START = 4096
_FOLDERS = ("velodyne", "velodyne_points/data", "data")
"""Subfolders in which KITTI keeps its sweeps."""
_RECORDINGS = ("*.bag", "*.mcap", "*.db3", "*.bin", "*.pcd")


def open_recording(
    path: Path | str, *, topic: str | None = None, rate: float = RATE
) -> SensorRecording:
    """Open the recording in a file or folder, recognised by content and then by name.

    ROS 1 bags (format 2.0), ROS 2 bags (folder, .mcap or .db3, either with .zstd), KITTI and
    nuScenes sweeps, PCD files, and folders of sweeps or of the parts of a ROS 1 bag, which are read
    in the order of their names.

    Args:
        path: File or folder.
        topic: Topic of a bag; None: all its scans and clouds.
        rate: Rate of the sweeps in a folder, Hz.

    Raises:
        RecordingError: if the path does not exist, its kind is unknown, or nothing can be read;
            names the file and, where known, the byte.
    """
    path = Path(path)
    if not rate > 0.0:
        raise RecordingError(f"cannot be played at {rate:g} sweeps a second", file=path)
    try:
        return _folder(path, topic, rate) if path.is_dir() else _file(path, topic, rate)
    except OSError as error:
        raise RecordingError(error.strerror or str(error), file=path) from None


def _file(path: Path, topic: str | None, rate: float) -> SensorRecording:
    start = _start(path)
    if not start:
        raise RecordingError(f"is empty; {KNOWN}", file=path, offset=0)
    if is_bag(path, start):
        return BagRecording(path, [path], topic)
    read = _reader(path, start)
    if read is None:
        raise RecordingError(f"is not a recording; {KNOWN}", file=path, offset=0)
    return SweepRecording(path, [path], read, rate)


def _folder(path: Path, topic: str | None, rate: float) -> SensorRecording:
    if files := message_files(path):
        return _parts(path, files, topic)
    for folder in (path, *(path / name for name in _FOLDERS)):
        sweeps = _named(folder, ("*.pcd.bin",)) or _named(folder, ("*.pcd",))
        sweeps = sweeps or _named(folder, ("*.bin",))
        if sweeps:
            recording = SweepRecording(path, sweeps, _read_any, rate)
            others = set(_named(folder, _RECORDINGS)) - set(sweeps)
            if others:
                names = _names(sorted(others, key=natural_order))
                recording.warnings.append(
                    f"{folder}: {len(sweeps)} {sweeps[0].suffix} sweeps are read; recordings of "
                    f"other kinds are ignored: {names}"
                )
            return recording
    if bags := _named(path, ("*.bag", "*.bag.active")):
        return _parts(path, bags, topic)
    raise RecordingError(f"holds no recording; {KNOWN}", file=path)


def _parts(path: Path, files: Sequence[Path], topic: str | None) -> BagRecording:
    bag = BagRecording(path, files, topic)
    if len(files) > 1:
        read = f"{len(files)} files are read one after the other: {_names(files)}"
        bag.warnings.append(f"{path}: {read}")
    return bag


def _named(folder: Path, patterns: Sequence[str]) -> list[Path]:
    found = {file for pattern in patterns for file in folder.glob(pattern) if file.is_file()}
    return sorted(found, key=natural_order)


def _names(files: Sequence[Path]) -> str:
    return ", ".join(file.name for file in files[:3]) + (", …" if len(files) > 3 else "")


def _read_any(file: Path) -> CloudSweep:
    """Read one sweep of a folder."""
    start = _start(file)
    read = _reader(file, start)
    if not start or read is None:
        raise RecordingError("is empty" if not start else "is not a sweep", file=file, offset=0)
    return read(file)


def _reader(file: Path, start: bytes) -> Callable[[Path], CloudSweep] | None:
    if looks_like_pcd(start):
        return read_pcd
    name = file.name.lower()
    if name.endswith(".pcd.bin"):
        return read_nuscenes
    if name.endswith(".bin"):
        return read_nuscenes if has_rings(start) else read_kitti
    return None


def _start(file: Path) -> bytes:
    try:
        if file.exists() and not file.is_file():
            raise RecordingError("is neither a file nor a folder", file=file)
        with file.open("rb") as stream:
            return stream.read(_START)
    except OSError as error:
        raise RecordingError(error.strerror or str(error), file=file) from None
