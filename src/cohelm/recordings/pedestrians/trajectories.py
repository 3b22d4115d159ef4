"""Pedestrian trajectories in the text formats of ETH, UCY, social-lstm, HERMES and JuPedSim.

The format follows from the number of columns, or from a header of lines that begin with ``#``:

    8   obsmat      frame, id, x, z, y, v_x, v_z, v_y     m; 0.4 s from frame to frame
    4   social-lstm frame, id, x, y                       m; 0.4 s; ``?`` where not annotated
    5   HERMES      id, frame, x, y, z                    cm; 1/16 s
    #   JuPedSim    id, frame, x, y, …                    m, or as ``x/cm`` says; ``framerate:``

The last one is also that of the pedestrian data archive of Jülich.

The step of the frame numbers is found in the file (6 in ETH, 10 in UCY). The velocities of an
obsmat file are ignored: they are differences of the positions, computed differently in each file.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.errors import RecordingError
from cohelm.recordings.pedestrians.scales import METRES, Unit, check_scale, read_scales

LONGEST_GAP = 5
"""Maximum gap between two samples of a person, in steps of the file, that is interpolated. Frames,
not seconds: gaps are annotators' omissions."""
MAX_PACE = 2.0
"""Maximum speed of people who walk on beyond a film, m/s: the ends of tracks are noisy."""


@value
class Trajectories:
    """Trajectories of n people in k samples, grouped by person and in order of time."""

    name: str
    """Name of the file."""
    step: float
    """Time between two annotated frames, s."""
    id: Annotated[Integers, Shape("n")]
    """As in the file, ascending."""
    first: Annotated[Integers, Shape("n+1")]
    """Index of each person's first sample; the last entry is k."""
    time: Annotated[Floats, Shape("k")]
    """s since the file's first frame; negative where :meth:`walking_on` extended a track."""
    position: Annotated[Floats, Shape("k 2")]
    """In the frame of the file, m."""
    velocity: Annotated[Floats, Shape("k 2")]
    """Velocity of the curve through the positions, m/s."""
    groups: tuple[tuple[int, ...], ...] = ()
    """Ids of people who walk together, as annotated; a person may be in several groups."""

    @property
    def begin(self) -> Floats:
        """Time of each person's first sample (n,), s."""
        return self.time[self.first[:-1]]

    @property
    def end(self) -> Floats:
        """Time of each person's last sample (n,), s."""
        return self.time[self.first[1:] - 1]

    @property
    def instants(self) -> Floats:
        """Times with any sample, ascending, s."""
        return np.unique(self.time)

    def last_before(self, time: float) -> Integers:
        """Index (n,) of each person's last sample at or before ``time``, s; −1: none."""
        if len(self.id) == 0:
            return np.empty(0, dtype=np.int64)
        count = np.add.reduceat(self.time <= time, self.first[:-1], dtype=np.int64)
        return np.where(count > 0, self.first[:-1] + count - 1, -1)

    def at(self, time: float) -> tuple[Integers, Floats, Floats]:
        """People present at ``time``: ids (m,), positions (m, 2) m, velocities (m, 2) m/s.

        Positions lie on a cubic Hermite curve through the samples, with the velocity at each
        sample that of the parabola through its neighbours; the velocity is the exact derivative.
        A person is absent before the first and after the last sample, and within a gap of more
        than ``LONGEST_GAP`` steps of the file.
        """
        if len(self.id) == 0:
            return self.id, np.empty((0, 2)), np.empty((0, 2))
        last = self.last_before(time)
        a = np.maximum(last, self.first[:-1])
        b = np.minimum(a + 1, self.first[1:] - 1)
        length = self.time[b] - self.time[a]
        there = (last >= 0) & (time <= self.end)
        there &= (length <= (LONGEST_GAP + 0.5) * self.step) | (self.time[a] == time)
        position, velocity = self._between(time, a[there], b[there])
        return self.id[there], position, velocity

    def only(self, who: Booleans) -> Trajectories:
        """Select people by a mask (n,)."""
        count = np.diff(self.first)
        rows = np.repeat(who, count)
        return replace(
            self,
            id=self.id[who],
            first=np.append(0, np.cumsum(count[who])),
            time=self.time[rows],
            position=self.position[rows],
            velocity=self.velocity[rows],
        )

    def walking_on(self, seconds: float) -> Trajectories:
        """Extend each person's track straight on before its first and after its last sample, s.

        At the mean velocity of its first or last second, at most ``MAX_PACE``; who is seen once
        stays as seen. Times before the first frame are negative.
        """
        if not seconds or len(self.id) == 0:
            return self
        away = self.step * np.arange(1, math.ceil(seconds / self.step) + 1)
        first, time, position, velocity = [0], [], [], []
        for a, b in zip(self.first[:-1], self.first[1:], strict=True):
            t, x = self.time[a:b], self.position[a:b]
            count = len(away) if b - a > 1 else 0
            came = _pace(t, x, 0, min(int(np.searchsorted(t, t[0] + 1.0)), b - a - 1))
            goes = _pace(t, x, max(int(np.searchsorted(t, t[-1] - 1.0, "right")) - 1, 0), b - a - 1)
            before, after = away[:count][::-1], away[:count]
            time += [t[0] - before, t, t[-1] + after]
            position += [x[0] - before[:, None] * came, x, x[-1] + after[:, None] * goes]
            velocity += [np.tile(came, (count, 1)), self.velocity[a:b], np.tile(goes, (count, 1))]
            first.append(first[-1] + 2 * count + b - a)
        return replace(
            self,
            first=np.array(first),
            time=np.concatenate(time),
            position=np.concatenate(position),
            velocity=np.concatenate(velocity),
        )

    def _between(self, time: float, a: Integers, b: Integers) -> tuple[Floats, Floats]:
        """Evaluate the curve from samples ``a`` to ``b``; b = a at the last sample."""
        h = np.where(b > a, self.time[b] - self.time[a], 1.0)[:, None]
        s = (time - self.time[a])[:, None] / h
        p, q, u, v = self.position[a], self.position[b], self.velocity[a], self.velocity[b]
        d = q - p
        position = p + h * u * s + (3.0 * d - h * (2.0 * u + v)) * s**2
        position += (h * (u + v) - 2.0 * d) * s**3
        velocity = u + (6.0 * d / h - 4.0 * u - 2.0 * v) * s + (3.0 * (u + v) - 6.0 * d / h) * s**2
        return position, velocity


def _pace(time: Floats, position: Floats, a: int, b: int) -> Floats:
    """Mean velocity (2,) from sample ``a`` to ``b``, at most ``MAX_PACE``, m/s; 0 of one sample."""
    elapsed = time[b] - time[a]
    mean: Floats = (position[b] - position[a]) / (elapsed or 1.0)
    return mean * min(1.0, MAX_PACE / max(float(np.hypot(*mean)), 1e-9))


def read_trajectories(
    file: Path | str,
    *,
    step: float | None = None,
    unit: Unit | None = None,
    groups: Path | str | None = None,
) -> Trajectories:
    """Read trajectories from a text file in one of the formats above.

    A social-lstm export of ETH counts frames of a 15 Hz film in tens and takes them as 0.4 s, like
    all its users; truly they were 0.67 s: give ``step`` where that matters.

    Args:
        file: The trajectories.
        step: Time between two frames, s; None: that of the header, or default of the format.
        unit: Unit of the positions; None: that of the header, or default of the format.
        groups: Lists of ids of people who walk together, one group per line; None: the file beside
            it, ``groups.txt`` for ``obsmat.txt``, if it exists.

    Raises:
        RecordingError: if a file is missing, empty, or has a line that is not valid; names the file
            and the line. Also if another unit is likely: people do not walk at 0.01 m/s.
    """
    file = Path(file)
    lines = _lines(file)
    header = "\n".join(" ".join(words) for _, words in lines if words[0].startswith("#"))
    table = _numbers(file, [line for line in lines if not line[1][0].startswith("#")])
    frame, who, position = _columns(file, table, has_header=bool(header))
    usual, written = read_scales(header, table.shape[1])
    scale = unit or written
    position = position * METRES[scale]
    if step is None and usual is None:
        raise RecordingError("its header names no frame rate: give the step, s", file=file)
    order = np.lexsort((frame, who))
    frame, who, position = frame[order], who[order], position[order]
    same = who[1:] == who[:-1]
    steps = np.diff(frame)[same]
    if np.any(steps == 0):
        k = int(np.flatnonzero(same & (np.diff(frame) == 0))[0])
        raise RecordingError(f"person {who[k]} is in frame {frame[k]:g} twice", file=file)
    seconds = step or usual or 0.0
    tick = seconds / _most_common(steps if len(steps) else np.ones(1))
    time = (frame - frame.min()) * tick
    beside = file.with_name(file.name.replace("obsmat", "groups"))
    if groups is None and beside != file and beside.is_file():
        groups = beside
    found = trajectories_of(
        name=file.name,
        step=seconds,
        who=who,
        time=time,
        position=position,
        groups=() if groups is None else read_groups(groups),
    )
    check_scale(np.hypot(*found.velocity.T), found.position, scale, file)
    return found


def trajectories_of(
    *,
    name: str,
    step: float,
    who: Integers,
    time: Floats,
    position: Floats,
    groups: tuple[tuple[int, ...], ...] = (),
) -> Trajectories:
    """Build trajectories from samples that are grouped by person and in order of time.

    Args:
        name: Name of the file.
        step: Time between two annotated frames, s.
        who: (k,) ids.
        time: (k,), s.
        position: (k, 2), m.
        groups: Ids of people who walk together.
    """
    ids, first = np.unique(who, return_index=True)
    return Trajectories(
        name=name,
        step=step,
        id=ids,
        first=np.append(first, len(who)),
        time=time,
        position=position,
        velocity=_tangents(time, position, who[1:] == who[:-1]),
        groups=groups,
    )


def read_groups(file: Path | str) -> tuple[tuple[int, ...], ...]:
    """Read groups, one list of ids per line; empty lines and repeated ids are ignored.

    Raises:
        RecordingError: if the file is missing or a word is not an id; names the file and the line.
    """
    found = []
    for number, words in _lines(Path(file)):
        try:
            members = dict.fromkeys(int(word) for word in words)
        except ValueError:
            raise RecordingError(
                f"line {number}: expected ids, whole numbers, found {' '.join(words)[:40]!r}",
                file=file,
            ) from None
        found.append(tuple(members))
    return tuple(found)


def _lines(file: Path) -> list[tuple[int, list[str]]]:
    """(number from 1, words) of all lines that are not empty."""
    try:
        if file.exists() and not file.is_file():
            raise RecordingError("is not a file", file=file)
        text = file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RecordingError("is not text", file=file, offset=error.start) from None
    except OSError as error:
        raise RecordingError(error.strerror or str(error), file=file) from None
    lines = enumerate(text.split("\n"), 1)
    return [(number, words) for number, line in lines if (words := line.split())]


def _numbers(file: Path, lines: list[tuple[int, list[str]]]) -> Floats:
    """Table (rows, columns) of finite numbers; rows with a ``?`` are skipped."""
    if not lines:
        raise RecordingError("is empty: it needs a line for each person and frame", file=file)
    width = len(lines[0][1])
    rows = []
    for number, words in lines:
        if len(words) != width:
            raise RecordingError(
                f"line {number}: has {len(words)} columns, the first has {width}", file=file
            )
        if "?" in words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = [np.nan]
        if not np.isfinite(row).all():
            raise RecordingError(
                f"line {number}: expected numbers only, found {' '.join(words)[:60]!r}", file=file
            )
        rows.append(row)
    return np.array(rows, dtype=float).reshape(len(rows), width)


def _columns(file: Path, table: Floats, *, has_header: bool) -> tuple[Floats, Integers, Floats]:
    """(frame, id, position in the file's unit) of a table of numbers."""
    width = table.shape[1]
    if width < 4 if has_header else width not in {4, 5, 8}:
        raise RecordingError(
            f"has {width} columns; trajectories have 8 (obsmat), 4 (social-lstm), 5 (HERMES), or 4 "
            "and more behind a header of JuPedSim",
            file=file,
        )
    if len(table) == 0:
        raise RecordingError("has no positions: every one is '?'", file=file)
    if np.abs(table).max() > _MAX_NUMBER:
        raise RecordingError(f"holds a number beyond {_MAX_NUMBER:g}", file=file)
    id_first = has_header or width == 5
    frame, who = (table[:, 1], table[:, 0]) if id_first else (table[:, 0], table[:, 1])
    if np.any(who != np.rint(who)):
        raise RecordingError(
            f"has an id that is not a whole number, {who[who != np.rint(who)][0]:g}", file=file
        )
    columns = [2, 4] if width == 8 and not has_header else [2, 3]
    return frame, who.astype(np.int64), table[:, columns]


def _most_common(steps: Floats) -> float:
    values, counts = np.unique(steps, return_counts=True)
    return float(values[np.argmax(counts)])


def _tangents(time: Floats, position: Floats, same: Booleans) -> Floats:
    """Velocities (k, 2), m/s, of the parabola through a sample and its two neighbours.

    At an end it is the mean velocity to the one neighbour; of a single sample it is 0.
    """
    if len(time) == 1:
        return np.zeros_like(position)
    h = np.where(same, np.diff(time), 1.0)[:, None]
    mean = np.diff(position, axis=0) / h
    nothing = np.zeros((1, 1))
    before = np.concatenate([nothing, np.where(same[:, None], h, 0.0)])
    after = np.concatenate([np.where(same[:, None], h, 0.0), nothing])
    mean_before = np.concatenate([np.zeros((1, 2)), mean])
    mean_after = np.concatenate([mean, np.zeros((1, 2))])
    # The nearer neighbour weighs more; a missing one has h = 0 and must not weigh at all.
    ends = (before == 0.0) | (after == 0.0)
    weight_before = np.where(ends, before > 0.0, after)
    weight_after = np.where(ends, after > 0.0, before)
    total = np.maximum(weight_before + weight_after, np.finfo(float).tiny)
    tangents: Floats = (weight_before * mean_before + weight_after * mean_after) / total
    return tangents


_MAX_NUMBER = 1e9
"""Beyond it floats are too coarse for neighbouring positions or frames."""
