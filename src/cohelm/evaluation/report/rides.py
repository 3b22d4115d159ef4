"""Rides as a table: columns, derived columns, and the groups that are compared."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.metrics.measures import MEASURES

Row = Mapping[str, Any]
Key = tuple[str, ...]
"""Values of the compared columns, in their order."""

_WHOLE_RIDES = ("time", "path_length", "path_length_short", "heading_change")
_ARRIVED = ("reached", "success")
"""Outcomes of rides that arrived; ``success`` is that of worlds with their own rules, as BARN's."""
_ENDS = {**dict.fromkeys(_ARRIVED, 0), "timeout": 1, "stopped": 1, "collision": 2, "fell": 3}
_SHARED_DRAWS = ("rider",)
"""Columns that do not change the draw of a seed: all riders of one case and seed meet the same
people, and ``autonomous`` rides are equal for all of them."""


class Rides:
    """Rides of one sweep, in the order of their rows.

    Args:
        rows: as ``ride_row`` gives them; a missing column has no value.
        by: compared columns; the last one names the contenders, those before it the case.
        curves: (j, 8) of each ride, as ``series_of`` gives it; None: without a curve.
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
        """Seed of each ride, (k,)."""
        return [int(row["seed"]) for row in self.rows]

    @property
    def cases(self) -> list[Key]:
        """Cases in the order of the rows; ``()`` where there is only one."""
        return list(dict.fromkeys(_key(row, self.by[:-1]) for row in self.rows))

    @property
    def contenders(self) -> list[str]:
        """Contenders in the order of the rows."""
        return list(dict.fromkeys(_text(row.get(self.by[-1])) for row in self.rows))

    def of(self, case: Key | None = None, contender: str | None = None) -> Rides:
        """Rides of a case and of a contender; None: of all."""
        return self.take(
            i
            for i, row in enumerate(self.rows)
            if (case is None or _key(row, self.by[:-1]) == case)
            and (contender is None or _text(row.get(self.by[-1])) == contender)
        )

    def split(self) -> dict[Key, dict[str, Rides]]:
        """Case → contender → rides, in the order of the rows."""
        found: dict[Key, dict[str, list[int]]] = {}
        for i, row in enumerate(self.rows):
            contender = _text(row.get(self.by[-1]))
            found.setdefault(_key(row, self.by[:-1]), {}).setdefault(contender, []).append(i)
        return {
            case: {name: self.take(at) for name, at in each.items()} for case, each in found.items()
        }

    def by_contender(self) -> dict[str, Rides]:
        """Contender → its rides of all cases."""
        return {name: self.of(contender=name) for name in self.contenders}

    def only(self, **columns: Any) -> Rides:
        """Rides with some values of columns: ``only(mode="shared")``."""
        return self.take(
            i
            for i, row in enumerate(self.rows)
            if all(row.get(key) == each for key, each in columns.items())
        )

    def take(self, indices: Iterable[int]) -> Rides:
        """Rides by index."""
        at = list(indices)
        return Rides([self.rows[i] for i in at], self.by, [self.curves[i] for i in at])

    def has(self, name: str) -> bool:
        """Check that some ride has a value of a measure."""
        return bool(np.isfinite(self.column(name)).any())

    def column(self, name: str) -> Floats:
        """Values of a measure, (k,), NaN where a ride has none; yes or no as 1 or 0.

        Time, length and total heading change are those of rides that arrived.
        """
        if name == "time_ratio":
            time, empty = self.column("time"), self.column("time_empty_floor")
            there = np.isfinite(time) & (empty > 0.0)
            ratio: Floats = np.full(len(self), np.nan)
            np.divide(time, empty, out=ratio, where=there)
            return ratio
        if name in _YES_OR_NO:
            found: Booleans = np.array([_YES_OR_NO[name](row) for row in self.rows], dtype=bool)
            return found.astype(float)
        values = np.array([number(row.get(name)) for row in self.rows], dtype=float)
        return np.where(self.reached, values, np.nan) if name in _WHOLE_RIDES else values

    @property
    def reached(self) -> Booleans:
        """Rides that arrived, (k,)."""
        return self.column("reached") > 0.0

    @property
    def person_collision(self) -> Booleans:
        """Rides in which the moving chair and a person touched, (k,)."""
        return self.column("person_collision") > 0.0

    @property
    def any_collision(self) -> Booleans:
        """Rides with a collision with a person or a wall, (k,)."""
        return self.column("any_collision") > 0.0

    @property
    def program_error(self) -> Booleans:
        """Rides that a program error ended, (k,); their outcome is unknown."""
        return self.column("program_error") > 0.0

    def difference(self, other: Rides, name: str) -> Floats:
        """Difference of a measure from the other's, pair by pair in the order of the rows, (c,)."""
        i, j = self.pairs(other)
        return self.column(name)[i] - other.column(name)[j]

    def pairs(self, other: Rides) -> tuple[list[int], list[int]]:
        """Indices of rides in both tables that share case and seed: the first of each."""
        there: dict[Any, int] = {}
        for j, row in enumerate(other.rows):
            there.setdefault(self._case_and_seed(row), j)
        mine: dict[Any, int] = {}
        for i, row in enumerate(self.rows):
            mine.setdefault(self._case_and_seed(row), i)
        both = [(i, there[key]) for key, i in mine.items() if key in there]
        return [i for i, _ in both], [j for _, j in both]

    @property
    def has_shared_draws(self) -> bool:
        """Check that some rides share their draw: the riders of one case and seed."""
        shared = [key for key in self.by[:-1] if key in _SHARED_DRAWS]
        return any(len({_text(row.get(key)) for row in self.rows}) > 1 for key in shared)

    def units(self, indices: Iterable[int]) -> list[tuple[Key, int]]:
        """Independent draw of each of some rides: case and seed, for all riders."""
        columns = [key for key in self.by[:-1] if key not in _SHARED_DRAWS]
        rows = [self.rows[i] for i in indices]
        return [(_key(row, columns), int(row["seed"])) for row in rows]

    def _case_and_seed(self, row: Row) -> tuple[Key, int]:
        return _key(row, self.by[:-1]), int(row["seed"])


def number(content: Any) -> float:
    """A cell as a number; NaN where it is none."""
    try:
        return float(content)
    except (TypeError, ValueError):
        return math.nan


def severity(row: Row) -> int:
    """Severity of a ride's end: 0 reached, 1 not reached, 2 a collision, 3 a program error."""
    return _ENDS.get(str(row.get("outcome")), 3)


def measures_of(rides: Rides) -> list[str]:
    """Measures with values: those of the table of measures first, in their order."""
    columns = dict.fromkeys(key for row in rides.rows for key in row)
    skip = {*rides.by, *MEASURES, "seed", "raters"}
    others = [key for key in columns if key not in skip and _is_numeric(rides, key)]
    return [name for name in (*MEASURES, *others) if name != "success" and rides.has(name)]


def _is_numeric(rides: Rides, key: str) -> bool:
    given = [row.get(key) for row in rides.rows]
    given = [each for each in given if each is not None and each != ""]
    return bool(given) and all(
        isinstance(each, int | float) and not isinstance(each, bool) for each in given
    )


_YES_OR_NO: Mapping[str, Callable[[Row], bool]] = {
    "reached": lambda row: row.get("outcome") in _ARRIVED,
    "program_error": lambda row: row.get("outcome") == "error",
    "person_collision": lambda row: number(row.get("collisions_person")) > 0,
    "wall_collision": lambda row: number(row.get("collisions_wall")) > 0,
    "standing_contact": lambda row: number(row.get("standing_contacts")) > 0,
    "any_collision": lambda row: any(
        number(row.get(key)) > 0 for key in ("collisions_person", "collisions_wall")
    ),
}


def _key(row: Row, columns: Sequence[str]) -> Key:
    return tuple(_text(row.get(name)) for name in columns)


def _text(content: Any) -> str:
    return "" if content is None else str(content)
