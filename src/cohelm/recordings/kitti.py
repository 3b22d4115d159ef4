"""Sweeps of KITTI's Velodyne (.bin), with calibration and labels where they stand beside.

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
from cohelm.recordings.sweep import AT_REST, Sweep, read_bytes, read_rows

HEIGHT = 1.73
"""Of the Velodyne above the road, m: KITTI's description of its setup."""

REACH = 120.0
"""Of a HDL-64E, m: its data sheet."""

PEOPLE = frozenset({"Pedestrian", "Person_sitting"})

_VISIBLE = {0: 1.0, 1: 0.6, 2: 0.3}
"""Roughly, for KITTI's fully visible, partly and largely occluded; 3, unknown, counts as 1."""

_LARGEST_TEXT = 1 << 20


def read_kitti(file: Path) -> Sweep:
    """The sweep; its people are told where labels and calibration are found beside it.

    For ``name.bin`` these are ``name.calib.txt`` and ``name.label.txt``, or ``name.txt`` in the
    folders ``calib`` and ``label_2`` beside its own.

    Raises:
        RecordingError: if the file cannot be read or holds no points.
    """
    rows, damage = read_rows(file, 4)
    people = None
    label, calibration = _beside(file, "label", "label_2"), _beside(file, "calib", "calib")
    if label is not None:
        try:
            if calibration is None:
                raise RecordingError("is of no use without its calibration", file=label)  # noqa: TRY301  # told as any other fault of the labels
            people = _people(label, _camera(calibration))
        except RecordingError as error:
            damage = (*damage, error)
    return Sweep(
        points=rows[:, :3],
        range_max=REACH,
        mount=np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0]),
        pose=AT_REST,
        people=people,
        damage=damage,
    )


def read_labels(label: Path, recording: Path) -> Labels:
    """The people of a label file, at time 0, in the frame of the Velodyne's robot.

    The calibration is looked for beside the labels, then beside the recording, as for
    :func:`read_kitti`.

    Raises:
        RecordingError: if there is no calibration, or either file makes no sense.
    """
    named = label.with_name(f"{label.name.removesuffix('.txt').removesuffix('.label')}.bin")
    found = [_beside(file, "calib", "calib") for file in (named, recording)]
    calibration = next((file for file in found if file is not None), None)
    if calibration is None:
        raise RecordingError("is of no use without its calibration", file=label)
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
        raise RecordingError("wants R0_rect of 9 and Tr_velo_to_cam of 12 numbers", file=file)
    total = np.eye(4)
    total[:3] = turn.reshape(3, 3) @ move.reshape(3, 4)
    if abs(np.linalg.det(total)) < 0.5:
        raise RecordingError("R0_rect and Tr_velo_to_cam are no rotations", file=file)
    return total


def _people(file: Path, camera: Floats) -> Floats:
    """(k, 3): where the boxes of people have their centres, and what share of them is seen."""
    found = []
    back = np.linalg.inv(camera)
    for words in _lines(file):
        if words[0] not in PEOPLE:
            continue
        numbers = _floats(file, words[1:15])
        if numbers.size != 14:
            raise RecordingError(f"a label of {numbers.size} numbers instead of 14", file=file)
        truncated, occluded, height = numbers[0], numbers[1], numbers[7]
        centre = numbers[10:13] - (0.0, 0.5 * height, 0.0)
        x, y = (back @ np.append(centre, 1.0))[:2]
        visible = _VISIBLE.get(int(occluded), 1.0) * (1.0 - min(max(truncated, 0.0), 1.0))
        found.append((x, y, visible))
    return np.array(found, dtype=float).reshape(-1, 3)


def _lines(file: Path) -> list[list[str]]:
    text = read_bytes(file, _LARGEST_TEXT).decode("utf-8", "replace")
    return [words for line in text.splitlines() if (words := line.split())]


def _floats(file: Path, words: list[str]) -> Floats:
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.array([np.nan])
    if not np.isfinite(numbers).all():
        raise RecordingError(f"wants numbers and has {' '.join(words)[:60]!r}", file=file)
    return numbers
