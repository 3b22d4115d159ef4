"""Destinations of earlier rides, as the prior of destination inference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from cohelm.live.sessions.records import SessionSummary
from cohelm.scenarios import Scenario


def with_habits(scenario: Scenario, sessions: Iterable[SessionSummary]) -> Scenario:
    """Return a scenario whose inference knows how often each destination was reached.

    Sessions that were deleted are forgotten with it. Habits that the scenario gives stay.

    Args:
        scenario: Scenario of the drive.
        sessions: Stored sessions; only those of the same scene count.
    """
    destinations = scenario.destinations
    if destinations.inference.habits or not destinations.infer:
        return scenario
    counts = Counter(
        ride.destination
        for summary in sessions
        if summary.session.scene == scenario.name
        for ride in summary.rides
        if ride.outcome == "arrived"
    )
    inference = destinations.inference.model_copy(update={"habits": dict(sorted(counts.items()))})
    known = destinations.model_copy(update={"inference": inference})
    return scenario.model_copy(update={"destinations": known})
