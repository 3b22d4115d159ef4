"""``cohelm rate``: store a person's rating beside the ride."""

from __future__ import annotations

import json as json_format
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cohelm.cli.report import print_line, write_json
from cohelm.errors import ConfigError
from cohelm.evaluation.report import Rides, read_rides
from cohelm.evaluation.report.ratings import (
    add_rating,
    rating_of,
    read_ratings,
    ride_name,
    with_ratings,
)
from cohelm.evaluation.report.store import has_arrow, write_episodes
from cohelm.evaluation.sweeps.store import EPISODES

RIDE = "ride.json"


@dataclass(frozen=True)
class RidePick:
    """Selection of one ride of a folder."""

    columns: Sequence[str] = ()
    """``column=value`` that together select the ride."""
    seed: int | None = None
    """Seed of the ride; None: any."""


def rate(
    folder: Path,
    rating: int | None,
    pick: RidePick,
    *,
    rater: str = "",
    note: str = "",
    json: bool = False,
) -> int:
    """Store a rating of one ride, or list the ratings; returns 0.

    Args:
        folder: results of a bench, or of ``cohelm run --out``.
        rating: 1 (bad) to 5 (good); None: list the ratings.
        pick: selects the ride.
        rater: pseudonym; an earlier rating of the ride by the same person is replaced.
        note: remark.
        json: print JSON.

    Raises:
        ConfigError: if no ride or several are selected, or the ratings cannot be read.
    """
    if rating is None:
        return _list(folder, json=json)
    rides = _rides(folder)
    row = _picked(rides, pick)
    given = rating_of(row, rides.by, rating, rater, note)
    try:
        replaced = add_rating(folder, given)
        _refresh(folder)
    except OSError as cause:
        raise ConfigError(f"cannot be written to ({cause.strerror})", file=folder) from None
    said = {"ride": given.ride, "seed": given.seed, "rating": rating, "replaced": replaced}
    if json:
        write_json(said)
    else:
        print_line(
            f"{given.ride}, seed {given.seed}: {rating}" + (", replaced" if replaced else "")
        )
    return 0


def _rides(folder: Path) -> Rides:
    """Read the rides of a sweep, or the one of ``cohelm run --out``."""
    file = folder / RIDE
    if not file.is_file():
        return read_rides(folder)
    try:
        told: dict[str, Any] = json_format.loads(file.read_text(encoding="utf-8"))
        row = {"scenario": told["scenario"], "seed": int(told["seed"]), "outcome": told["outcome"]}
    except (OSError, UnicodeDecodeError, ValueError, KeyError, TypeError, RecursionError) as cause:
        raise ConfigError(f"cannot be read as a ride ({cause})", file=file) from None
    return Rides([row], ("scenario",))


def _picked(rides: Rides, pick: RidePick) -> Any:
    """The one selected row."""
    pairs = [each.partition("=") for each in pick.columns]
    for key, sign, _ in pairs:
        if not sign or key.strip() not in rides.by:
            raise ConfigError(f"select a ride by {', '.join(rides.by)}: KEY=VALUE", key="--ride")
    rows = [
        row
        for row in rides.rows
        if all(str(row.get(key.strip())) == word.strip() for key, _, word in pairs)
        and pick.seed in {None, row["seed"]}
    ]
    if len(rows) == 1:
        return rows[0]
    some = "; ".join(f"{ride_name(row, rides.by)}, seed {row['seed']}" for row in rows[:3])
    if rows:
        raise ConfigError(f"{len(rows)} rides match: {some} …; add more keys", key="--ride")
    raise ConfigError("no ride matches; see episodes.parquet or rows.csv", key="--ride")


def _refresh(folder: Path) -> None:
    """Add the ratings to the file of rides, where there is one."""
    if has_arrow() and (folder / EPISODES).is_file():
        rides = with_ratings(read_rides(folder / EPISODES), read_ratings(folder))
        write_episodes(rides, folder / EPISODES)


def _list(folder: Path, *, json: bool) -> int:
    if not folder.is_dir():
        raise ConfigError("is not a result folder", file=folder)
    ratings = read_ratings(folder)
    if json:
        keys = ("ride", "seed", "rating", "rater", "note")
        write_json({"ratings": [{key: getattr(each, key) for key in keys} for each in ratings]})
        return 0
    for each in ratings:
        words = ", ".join(part for part in (each.rater, each.note) if part)
        print_line(
            f"{each.ride}, seed {each.seed}: {each.rating}" + (f" ({words})" if words else "")
        )
    if not ratings:
        print_line("no ratings in this folder")
    return 0
