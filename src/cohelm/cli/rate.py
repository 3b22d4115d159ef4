"""``cohelm rate``: what somebody who rode said of it, kept beside the ride."""

from __future__ import annotations

import json as json_format
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cohelm.cli.report import OUTPUT, write_json
from cohelm.errors import ConfigError
from cohelm.evaluation.results import Rides, read_rides
from cohelm.evaluation.results.ratings import (
    add_rating,
    name_of,
    rating_of,
    read_ratings,
    with_ratings,
)
from cohelm.evaluation.results.store import EPISODES, has_arrow, write_episodes

RIDE = "ride.json"


def rate(
    folder: Path,
    rating: int | None,
    *,
    ride: Sequence[str] = (),
    seed: int | None = None,
    rater: str = "",
    note: str = "",
    json: bool = False,
) -> int:
    """Keep a rating of one ride, or say which there are; returns 0.

    Args:
        folder: of a bench's results, or of ``cohelm run --out``.
        rating: 1 (bad) to 5 (good); None: list those that were given.
        ride: ``column=value`` that together pick the ride.
        seed: of the ride; None: whichever the others pick.
        rater: a pseudonym; the same one's earlier rating of the ride is replaced.
        note: what else was said.
        json: for programs.

    Raises:
        ConfigError: if no ride or several are picked, or the ratings there cannot be read.
    """
    if rating is None:
        return _list(folder, json=json)
    rides = _rides(folder)
    row = _picked(rides, ride, seed)
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
        _line(f"{given.ride}, seed {given.seed}: {rating}" + (", replaced" if replaced else ""))
    return 0


def _rides(folder: Path) -> Rides:
    """Of a sweep, or the one of ``cohelm run --out``."""
    file = folder / RIDE
    if not file.is_file():
        return read_rides(folder)
    try:
        told: dict[str, Any] = json_format.loads(file.read_text(encoding="utf-8"))
        row = {"scenario": told["scenario"], "seed": int(told["seed"]), "outcome": told["outcome"]}
    except (OSError, UnicodeDecodeError, ValueError, KeyError, TypeError) as cause:
        raise ConfigError(f"is no ride that can be read ({cause})", file=file) from None
    return Rides([row], ("scenario",))


def _picked(rides: Rides, wanted: Sequence[str], seed: int | None) -> Any:
    """The one row that is meant."""
    pairs = [each.partition("=") for each in wanted]
    for key, sign, _ in pairs:
        if not sign or key.strip() not in rides.by:
            raise ConfigError(f"pick a ride by {', '.join(rides.by)}: KEY=VALUE", key="--ride")
    rows = [
        row
        for row in rides.rows
        if all(str(row.get(key.strip())) == word.strip() for key, _, word in pairs)
        and seed in {None, row["seed"]}
    ]
    if len(rows) == 1:
        return rows[0]
    some = "; ".join(f"{name_of(row, rides.by)}, seed {row['seed']}" for row in rows[:3])
    if rows:
        raise ConfigError(f"{len(rows)} rides are meant: {some} …; say more", key="--ride")
    raise ConfigError("no ride is meant; see episodes.parquet or rows.csv", key="--ride")


def _refresh(folder: Path) -> None:
    """Put the ratings beside the rides, where there is a file of them."""
    if has_arrow() and (folder / EPISODES).is_file():
        rides = with_ratings(read_rides(folder / EPISODES), read_ratings(folder))
        write_episodes(rides, folder / EPISODES)


def _list(folder: Path, *, json: bool) -> int:
    if not folder.is_dir():
        raise ConfigError("is no folder of results", file=folder)
    ratings = read_ratings(folder)
    if json:
        keys = ("ride", "seed", "rating", "rater", "note")
        write_json({"ratings": [{key: getattr(each, key) for key in keys} for each in ratings]})
        return 0
    for each in ratings:
        words = ", ".join(part for part in (each.rater, each.note) if part)
        _line(f"{each.ride}, seed {each.seed}: {each.rating}" + (f" ({words})" if words else ""))
    if not ratings:
        _line("nobody has rated a ride here")
    return 0


def _line(text: str) -> None:
    OUTPUT.print(text, markup=False, soft_wrap=True)
