"""Ratings of rides by people, 1 to 5, in a CSV file beside the rides (`docs/results.md`).

A rating belongs to one ride: the compared columns, the seed and the configuration. A sweep that is
resumed or repeated keeps the ratings of rides that have not changed.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.errors import ConfigError
from cohelm.evaluation.report.rides import Rides, Row

RATINGS = "ratings.csv"
LOWEST, HIGHEST = 1, 5


@dataclass(frozen=True)
class Rating:
    """Rating of one ride by one person."""

    ride: str
    """Compared columns: ``scene=crossing; planner=dwa``."""
    seed: int
    config: str
    """Configuration hash of the ride."""
    rating: int
    """1 (bad) to 5 (good)."""
    rater: str = ""
    """Pseudonym; empty: unknown."""
    note: str = ""

    def __post_init__(self) -> None:
        if not LOWEST <= self.rating <= HIGHEST:
            raise ConfigError(f"a rating is a whole number from {LOWEST} to {HIGHEST}")


def ride_name(row: Row, by: Sequence[str]) -> str:
    """Compared columns of a ride in one line."""
    return "; ".join(f"{key}={row.get(key)}" for key in by)


def read_ratings(folder: Path) -> list[Rating]:
    """Read all ratings of a folder, oldest first.

    Raises:
        ConfigError: if the file is not one of ratings.
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
        raise ConfigError(f"has a line that is not a rating ({cause})", file=file) from None


def with_ratings(rides: Rides, ratings: Sequence[Rating]) -> Rides:
    """Rides with the columns ``rating`` (mean over raters, NaN for none) and ``raters``."""
    given: dict[tuple[str, int, str], list[int]] = {}
    for each in ratings:
        given.setdefault((each.ride, each.seed, each.config), []).append(each.rating)
    rows: list[Mapping[str, object]] = []
    for row in rides.rows:
        key = (ride_name(row, rides.by), int(row["seed"]), str(row.get("config") or ""))
        found = given.get(key, [])
        mean = float(np.mean(found)) if found else np.nan
        rows.append({**row, "rating": mean, "raters": len(found)})
    return Rides(rows, rides.by, rides.curves)
