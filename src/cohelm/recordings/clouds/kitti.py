"""Sweeps of KITTI's Velodyne (.bin), with calibration and labels from files beside them.

A point is x, y, z, reflectance. Labels are boxes in the rectified frame of camera 0, standing on
(x, y, z) with y down; X_cam = R0_rect · Tr_velo_to_cam · X_velo (Geiger et al., CVPR 2012, and the
readme of the object benchmark).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import RecordingError
from cohelm.recordings.api import Labels
from cohelm.recordings.clouds.sweep import AT_REST, CloudSweep, read_bytes, read_rows

HEIGHT = 1.73
"""Height of the Velodyne above the road, m: KITTI's setup."""

REACH = 120.0
"""Range of a HDL-64E, m: data sheet."""

PEOPLE = frozenset({"Pedestrian", "Person_sitting"})

_VISIBLE = {0: 1.0, 1: 0.6, 2: 0.3}
"""Approximate visible share by KITTI's occlusion: none, partly, largely; 3 (unknown) is 1."""

_MAX_TEXT = 1 << 20


def read_kitti(file: Path) -> CloudSweep:
    """Read the sweep, with its people where labels and calibration lie beside it.

    For ``name.bin`` these are ``name.calib.txt`` and ``name.label.txt``, or ``name.txt`` in the
    folders ``calib`` and ``label_2`` beside its own.

    Raises:
        RecordingError: if the file cannot be read or holds no points.
    """
    points, damage = read_rows(file, 4)
    people = None
    label, calibration = _beside(file, "label", "label_2"), _beside(file, "calib", "calib")
    if label is not None:
        try:
            if calibration is None:
                raise RecordingError("needs its calibration, which is missing", file=label)  # noqa: TRY301  # reported like other faults of the labels
            people = _people(label, _camera(calibration))
        except RecordingError as error:
            damage = (*damage, error)
    return CloudSweep(
        points=points,
        range_max=REACH,
        mount=np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0]),
        pose=AT_REST,
        people=people,
        damage=damage,
    )


def read_labels(label: Path, recording: Path) -> Labels:
    """Read the people of a label file, at time 0, in the frame of the Velodyne's robot.

    The calibration is looked for beside the labels, then beside the recording, as for
    :func:`read_kitti`.

    Raises:
        RecordingError: if there is no calibration, or either file is not valid.
    """
    named = label.with_name(f"{label.name.removesuffix('.txt').removesuffix('.label')}.bin")
    found = [_beside(file, "calib", "calib") for file in (named, recording)]
    calibration = next((file for file in found if file is not None), None)
    if calibration is None:
        raise RecordingError("needs its calibration, which is missing", file=label)
    people = _people(label, _camera(calibration))
    return Labels(
        time=0.0, position=people[:, :2], id=np.full(len(people), -1), visible=people[:, 2]
    )


def _beside(file: Path, word: str, folder: str) -> Path | None:
    places = (
        file.with_suffix(f".{word}.txt"),
        file.parent.parent / folder / f"{file.stem}.txt",
    )
    return next((place for place in places if place.is_file()), None)


def _camera(file: Path) -> Floats:
    """The transform (4, 4) from the Velodyne to the rectified camera."""
    found = {}
    for words in _lines(file):
        if words[0].rstrip(":") in {"R0_rect", "R_rect", "Tr_velo_to_cam", "Tr_velo_cam"}:
            found[words[0][:2]] = _floats(file, words[1:])
    turn, move = found.get("R0", found.get("R_")), found.get("Tr")
    if turn is None or move is None or turn.size != 9 or move.size != 12:
        raise RecordingError("needs R0_rect with 9 and Tr_velo_to_cam with 12 numbers", file=file)
    total = np.eye(4)
    total[:3] = turn.reshape(3, 3) @ move.reshape(3, 4)
    if abs(np.linalg.det(total)) < 0.5:
        raise RecordingError("R0_rect and Tr_velo_to_cam are not rotations", file=file)
    return total


def _people(file: Path, camera: Floats) -> Floats:
    """(k, 3): x and y of the box centres of people, m, and their visible share."""
    found = []
    back = np.linalg.inv(camera)
    for words in _lines(file):
        if words[0] not in PEOPLE:
            continue
        numbers = _floats(file, words[1:15])
        if numbers.size != 14:
            raise RecordingError(f"a label has {numbers.size} numbers instead of 14", file=file)
        truncated, occluded, height = numbers[0], numbers[1], numbers[7]
        centre = numbers[10:13] - (0.0, 0.5 * height, 0.0)
        x, y = (back @ np.append(centre, 1.0))[:2]
        visible = _VISIBLE.get(int(occluded), 1.0) * (1.0 - min(max(truncated, 0.0), 1.0))
        found.append((x, y, visible))
    return np.array(found, dtype=float).reshape(-1, 3)


def _lines(file: Path) -> list[list[str]]:
    text = read_bytes(file, _MAX_TEXT).decode("utf-8", "replace")
    return [words for line in text.splitlines() if (words := line.split())]


def _floats(file: Path, words: list[str]) -> Floats:
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.array([np.nan])
    if not np.isfinite(numbers).all():
        raise RecordingError(f"expected numbers, found {' '.join(words)[:60]!r}", file=file)
    return numbers
