"""Rides as a table: columns, what is derived of them, and the groups that are compared."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.results.measures import KNOWN

Row = Mapping[str, Any]
Key = tuple[str, ...]
"""Values of the columns that say what was compared, in their order."""

_YES_OR_NO = ("reached", "hit_moving", "hit_standing", "hit_wall", "touched", "broke_off")
_OF_WHOLE_RIDES = ("time", "path_length", "path_length_short", "heading_change")
_ARRIVED = ("reached", "success")
"""Outcomes of who arrived; ``success`` is that of worlds with rules of their own, as BARN's."""
_ENDS = {**dict.fromkeys(_ARRIVED, 0), "timeout": 1, "stopped": 1, "collision": 2}
_ALIKE = ("rider",)
"""Columns of which a seed is the same draw whatever they say: all riders of a scene and a seed meet
the same people, and ``autonomous`` rides the same ride with each."""


class Rides:
    """Rides of the same sweep, in the order of their rows.

    Args:
        rows: as ``ride_row`` gives them; a column that a row lacks has no value in it.
        by: the columns that say what was compared; the last of them names what is contrasted,
            those before it the case in which it is.
        curves: (j, 8) of each ride, as ``series_of`` gives it; None: it has none.
    """

    def __init__(
        self,
        rows: Sequence[Row],
        by: Sequence[str] = ("planner",),
        curves: Sequence[Floats | None] = (),
    ) -> None:
        self.rows = tuple(rows)
        self.by = tuple(by)
        self.curves = tuple(curves) or (None,) * len(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    @property
    def seeds(self) -> list[int]:
        """(k,)."""
        return [int(row["seed"]) for row in self.rows]

    @property
    def cases(self) -> list[Key]:
        """What was ridden, in the order of the rows; ``()`` where nothing but one was."""
        return list(dict.fromkeys(_key(row, self.by[:-1]) for row in self.rows))

    @property
    def contenders(self) -> list[str]:
        """What is contrasted, in the order of the rows."""
        return list(dict.fromkeys(_text(row.get(self.by[-1])) for row in self.rows))

    def of(self, case: Key | None = None, contender: str | None = None) -> Rides:
        """Those of a case, or of all; those of a contender, or of all."""
        kept = (
            i
            for i, row in enumerate(self.rows)
            if (case is None or _key(row, self.by[:-1]) == case)
            and (contender is None or _text(row.get(self.by[-1])) == contender)
        )
        return self.take(kept)

    def split(self) -> dict[Key, dict[str, Rides]]:
        """Case → contender → rides, in the order of the rows."""
        found: dict[Key, dict[str, list[int]]] = {}
        for i, row in enumerate(self.rows):
            contender = _text(row.get(self.by[-1]))
            found.setdefault(_key(row, self.by[:-1]), {}).setdefault(contender, []).append(i)
        return {
            case: {name: self.take(at) for name, at in each.items()} for case, each in found.items()
        }

    def together(self) -> dict[str, Rides]:
        """Contender → its rides of all cases."""
        return {name: self.of(contender=name) for name in self.contenders}

    def only(self, **what: Any) -> Rides:
        """Those whose columns are as given: ``only(mode="shared")``."""
        return self.take(
            i
            for i, row in enumerate(self.rows)
            if all(row.get(key) == each for key, each in what.items())
        )

    def take(self, indices: Iterable[int]) -> Rides:
        """Some of them."""
        at = list(indices)
        return Rides([self.rows[i] for i in at], self.by, [self.curves[i] for i in at])

    def has(self, name: str) -> bool:
        """Whether any ride says something of a measure."""
        return bool(np.isfinite(self.column(name)).any())

    def column(self, name: str) -> Floats:
        """A measure, (k,), NaN where a ride has none; shares as 0 or 1.

        Time, length and turning are those of rides that arrived: half a way is no short one.
        """
        if name == "time_ratio":
            time, alone = self.column("time"), self.column("time_alone")
            there = np.isfinite(time) & (alone > 0.0)
            ratio: Floats = np.full(len(self), np.nan)
            np.divide(time, alone, out=ratio, where=there)
            return ratio
        if name in _YES_OR_NO:
            found: Booleans = np.array([_is(name, row) for row in self.rows], dtype=bool)
            return found.astype(float)
        values = np.array([number(row.get(name)) for row in self.rows], dtype=float)
        return np.where(self.reached, values, np.nan) if name in _OF_WHOLE_RIDES else values

    @property
    def reached(self) -> Booleans:
        """Rides that arrived, (k,)."""
        return self.column("reached") > 0.0

    @property
    def hit_moving(self) -> Booleans:
        """Rides in which the moving chair and a person touched, (k,)."""
        return self.column("hit_moving") > 0.0

    @property
    def touched(self) -> Booleans:
        """Rides in which the moving chair touched somebody, or it touched something, (k,)."""
        return self.column("touched") > 0.0

    @property
    def broke_off(self) -> Booleans:
        """Rides that a fault of the program ended, (k,): nobody knows what they would have hit."""
        return self.column("broke_off") > 0.0

    def less(self, other: Rides, name: str) -> Floats:
        """A measure less the other's, pair by pair in the order of the rows, (c,); NaN: none."""
        i, j = self.pairs(other)
        return self.column(name)[i] - other.column(name)[j]

    def pairs(self, other: Rides) -> tuple[list[int], list[int]]:
        """Indices of rides here and there that share case and seed: the first of each."""
        there: dict[Any, int] = {}
        for j, row in enumerate(other.rows):
            there.setdefault(self._same(row), j)
        mine: dict[Any, int] = {}
        for i, row in enumerate(self.rows):
            mine.setdefault(self._same(row), i)
        both = [(i, there[key]) for key, i in mine.items() if key in there]
        return [i for i, _ in both], [j for _, j in both]

    @property
    def has_alike(self) -> bool:
        """Whether some rides share their draw with others: the riders of one scene and seed."""
        alike = [key for key in self.by[:-1] if key in _ALIKE]
        return any(len({_text(row.get(key)) for row in self.rows}) > 1 for key in alike)

    def units(self, indices: Iterable[int]) -> list[tuple[Key, int]]:
        """The independent draw that each of some rides belongs to: case and seed, whoever rides."""
        columns = [key for key in self.by[:-1] if key not in _ALIKE]
        rows = [self.rows[i] for i in indices]
        return [(_key(row, columns), int(row["seed"])) for row in rows]

    def _same(self, row: Row) -> tuple[Key, int]:
        return _key(row, self.by[:-1]), int(row["seed"])


def number(content: Any) -> float:
    """A cell as a number; NaN where it is none."""
    if isinstance(content, bool | int | float | np.integer | np.floating):
        return float(content)
    try:
        return float(content)
    except (TypeError, ValueError):
        return math.nan


def ended_badly(row: Row) -> int:
    """How badly a ride ended: 0 reached, 1 not reached, 2 a collision, 3 a fault of the program."""
    return _ENDS.get(str(row.get("outcome")), 3)


def measures_of(rides: Rides) -> list[str]:
    """Every measure of which the rides say something: those known first, in their order."""
    columns = dict.fromkeys(key for row in rides.rows for key in row)
    skip = {*rides.by, "seed", "success", "raters"}
    others = [key for key in columns if key not in KNOWN and key not in skip]
    others = [key for key in others if _is_measure(rides, key)]
    return [name for name in (*KNOWN, *others) if rides.has(name)]


def _is_measure(rides: Rides, key: str) -> bool:
    given = [row.get(key) for row in rides.rows]
    given = [each for each in given if each is not None and each != ""]
    return bool(given) and all(
        isinstance(each, int | float) and not isinstance(each, bool) for each in given
    )


def _is(name: str, row: Row) -> bool:
    match name:
        case "reached":
            return row.get("outcome") in _ARRIVED
        case "broke_off":
            return bool(row.get("outcome") == "error")
        case "hit_moving":
            return number(row.get("collisions_person")) > 0
        case "touched":
            return _is("hit_moving", row) or _is("hit_wall", row)
        case "hit_standing":
            return number(row.get("standing_contacts")) > 0
        case _:
            return number(row.get("collisions_wall")) > 0


def _key(row: Row, columns: Sequence[str]) -> Key:
    return tuple(_text(row.get(name)) for name in columns)


def _text(content: Any) -> str:
    return "" if content is None else str(content)
