"""What people who rode said, from 1 to 5: kept in a file of its own, beside the rides it is of.

A rating is of one ride: of what was compared, its seed, and its configuration. A sweep that is
gone on with or ridden anew keeps the ratings of rides that are still the same.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.errors import ConfigError
from cohelm.evaluation.results.rides import Rides, Row

RATINGS = "ratings.csv"
LOWEST, HIGHEST = 1, 5
_COLUMNS = ("ride", "seed", "config", "rating", "rater", "note")


@dataclass(frozen=True)
class Rating:
    """One person's word on one ride."""

    ride: str
    """What was compared: ``scene=crossing; planner=dwa``."""
    seed: int
    config: str
    """Its hash, as in the ride's row."""
    rating: int
    """1 (bad) to 5 (good)."""
    rater: str = ""
    """A pseudonym; empty: nobody said."""
    note: str = ""

    def __post_init__(self) -> None:
        if not LOWEST <= self.rating <= HIGHEST:
            raise ConfigError(f"a rating is a whole number from {LOWEST} to {HIGHEST}")


def name_of(row: Row, by: Sequence[str]) -> str:
    """What was compared in a ride, as one line."""
    return "; ".join(f"{key}={row.get(key)}" for key in by)


def rating_of(row: Row, by: Sequence[str], rating: int, rater: str = "", note: str = "") -> Rating:
    """A rating of a ride.

    Raises:
        ConfigError: if it is not from 1 to 5.
    """
    config = str(row.get("config") or "")
    return Rating(name_of(row, by), int(row["seed"]), config, rating, rater.strip(), note.strip())


def add_rating(folder: Path, given: Rating) -> bool:
    """Keep a rating; one that the same rater gave the same ride is replaced. Returns whether so.

    Raises:
        ConfigError: if the ratings that are there cannot be read.
        OSError: if the file cannot be written.
    """
    kept = [
        each for each in read_ratings(folder) if not given.rater or _whose(each) != _whose(given)
    ]
    replaced = len(kept) < len(read_ratings(folder))
    beside = folder / f"{RATINGS}.part"
    with beside.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(_COLUMNS)
        writer.writerows([getattr(each, key) for key in _COLUMNS] for each in [*kept, given])
    beside.replace(folder / RATINGS)
    return replaced


def read_ratings(folder: Path) -> list[Rating]:
    """All ratings in a folder, in the order in which they were given.

    Raises:
        ConfigError: if the file is not what :func:`add_rating` writes.
    """
    file = folder / RATINGS
    if not file.is_file():
        return []
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            return [
                Rating(
                    ride=row["ride"],
                    seed=int(row["seed"]),
                    config=row["config"],
                    rating=int(row["rating"]),
                    rater=row["rater"],
                    note=row["note"],
                )
                for row in csv.DictReader(stream)
            ]
    except (KeyError, TypeError, ValueError, UnicodeDecodeError, csv.Error, ConfigError) as cause:
        raise ConfigError(f"has a line that is no rating ({cause})", file=file) from None


def with_ratings(rides: Rides, ratings: Sequence[Rating]) -> Rides:
    """The rides with columns ``rating`` (mean over raters, NaN for none) and ``raters``."""
    given: dict[tuple[str, int, str], list[int]] = {}
    for each in ratings:
        given.setdefault((each.ride, each.seed, each.config), []).append(each.rating)
    rows: list[Mapping[str, object]] = []
    for row in rides.rows:
        key = (name_of(row, rides.by), int(row["seed"]), str(row.get("config") or ""))
        mine = given.get(key, [])
        mean = float(np.mean(mine)) if mine else np.nan
        rows.append({**row, "rating": mean, "raters": len(mine)})
    return Rides(rows, rides.by, rides.curves)


def _whose(each: Rating) -> tuple[str, int, str, str]:
    return each.ride, each.seed, each.config, each.rater
