"""Response of a rider, learned slowly from the stored rides, shown, and reset at once.

Each measured ride has its own estimates (``evaluation.metrics.rider``), stored with the ride and
deleted with it. Nothing else is stored but the time of the last reset.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from cohelm.config import Model
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import RideSummary, now_utc, stored_sessions
from cohelm.messages import RiderProfile

RESET = "response_reset"
"""Setting with the time of the last reset, ISO 8601, UTC."""
PRIOR_RIDES = 5
"""Weight of the value that is assumed before the first ride, rides: learning is slow."""
LATEST = 50
"""Number of rides that count at most, the latest ones."""


class Learned(NamedTuple):
    """A quantity that is learned."""

    prior: float
    """Value without a ride."""
    lower: float
    upper: float


LEARNED = {
    "tight_speed": Learned(0.8, 0.2, 0.8),
    "turn_share": Learned(1.0, 0.2, 1.0),
    "steadiness": Learned(1.0, 0.0, 1.0),
}
"""Measure of a ride → its prior and bounds; assumed."""


class RiderResponse(Model):
    """Response of a rider."""

    tight_speed: float = LEARNED["tight_speed"].prior
    """Speed in tight places, m/s."""
    turn_share: float = LEARNED["turn_share"].prior
    """Sharpness of turns, share of the chair's largest turn rate."""
    steadiness: float = LEARNED["steadiness"].prior
    """Steadiness of the hand, 0…1."""
    rides: Mapping[str, int] = {}
    """Number of rides behind each of them."""
    since: str = ""
    """Time of the last reset, ISO 8601, UTC; rides before it do not count."""


def rider_response(rides: Iterable[RideSummary], since: str = "") -> RiderResponse:
    """Estimate the response: the mean over rides and ``PRIOR_RIDES`` times the prior, bounded.

    Args:
        rides: Summaries in any order; those without measures do not count.
        since: Time of the last reset.
    """
    counted = sorted((r for r in rides if r.started >= since), key=lambda r: r.started)
    found: dict[str, float] = {}
    counts: dict[str, int] = {}
    for name, (prior, lower, upper) in LEARNED.items():
        values = [ride.measures[name] for ride in counted if name in ride.measures][-LATEST:]
        mean = (PRIOR_RIDES * prior + sum(values)) / (PRIOR_RIDES + len(values))
        found[name], counts[name] = min(max(mean, lower), upper), len(values)
    return RiderResponse(**found, rides=counts, since=since)


def stored_response(database: Database) -> RiderResponse:
    """Return the response of all stored rides; that without a ride if there is none.

    Raises:
        StoreError: The database cannot be read.
    """
    rides = [ride for session in stored_sessions(database) for ride in session.rides]
    return rider_response(rides, reset_at(database))


def reset_response(database: Database) -> None:
    """Forget the response: rides until now no longer count.

    Raises:
        StoreError: The database cannot be written.
    """
    database.set(RESET, now_utc())


def with_response(profile: RiderProfile, response: RiderResponse) -> RiderProfile:
    """Return a profile whose speed in tight places is at most the learned one, if there is one."""
    if not response.rides.get("tight_speed"):
        return profile
    tight = min(profile.tight_speed, response.tight_speed)
    return profile.model_copy(update={"tight_speed": tight})


def reset_at(database: Database) -> str:
    """Return the time of the last reset, ISO 8601; empty: there was none.

    Raises:
        StoreError: The database cannot be read.
    """
    return database.setting(RESET) or ""
