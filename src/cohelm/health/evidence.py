"""Evidence over time: a symptom becomes a finding when it lasts, and ends when it stays away."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from cohelm.health.values import Finding
from cohelm.messages import Reason


@dataclass(frozen=True, slots=True)
class Rule:
    """Treatment of one symptom."""

    confirm: float
    """Time for which it must last, s."""
    release: float
    """Time for which it must stay away, s."""
    stops: bool = True
    latched: bool = False


RULES: Mapping[Reason, Rule] = MappingProxyType(
    {
        Reason.SCAN_IMPLAUSIBLE: Rule(0.0, 1.0),
        Reason.SCAN_FROZEN: Rule(0.09, 1.0),
        Reason.SCAN_BLIND: Rule(0.09, 0.5),
        Reason.DRIVE_FAULT: Rule(0.0, 1.0, latched=True),
        Reason.ODOMETRY_FAULT: Rule(0.15, 1.0, latched=True),
        Reason.SCAN_MOTION: Rule(0.09, 1.0, latched=True),
        Reason.SENSORS_DISAGREE: Rule(0.2, 1.0, latched=True),
        Reason.POSE_FAULT: Rule(0.15, 0.5),
        Reason.LOST: Rule(0.25, 1.0),
        Reason.STICK_STUCK: Rule(0.0, 0.0),
        Reason.SCAN_PARTLY_BLIND: Rule(0.15, 1.0, stops=False),
        Reason.POSE_DOUBTFUL: Rule(0.3, 1.0, stops=False),
        Reason.DRIVE_WEAK: Rule(0.0, 5.0, stops=False, latched=True),
    }
)
"""Most serious first; times are assumed: two sweeps, or as long as a coincidence may last."""
_GAP = 0.12
"""Time without a symptom that does not interrupt it, s: it may come with every second sweep."""


@dataclass(frozen=True, slots=True)
class Track:
    """Course of one symptom."""

    reason: Reason
    first: float
    last: float
    confirmed: float | None = None


Evidence = tuple[Track, ...]
"""Symptoms in the order of ``RULES``."""
NO_EVIDENCE: Evidence = ()


def update_evidence(evidence: Evidence, symptoms: Iterable[Reason], time: float) -> Evidence:
    """Add the symptoms of one instant.

    Args:
        evidence: before.
        symptoms: present now.
        time: s.
    """
    now = set(symptoms)
    if not evidence and not now:
        return evidence
    before, out = {track.reason: track for track in evidence}, []
    for reason, rule in RULES.items():
        track = before.get(reason)
        if reason in now:
            if track is None or (track.confirmed is None and time - track.last > _GAP):
                track = Track(reason, first=time, last=time)
            lasted = time - track.first >= rule.confirm - 1e-9
            since = time if lasted and track.confirmed is None else track.confirmed
            out.append(Track(reason, track.first, time, since))
        elif track is not None and not _ended(track, rule, time):
            out.append(track)
    return tuple(out)


def without_latched(evidence: Evidence) -> Evidence:
    """Evidence without latched findings; what is still wrong is found again."""
    return tuple(
        track for track in evidence if track.confirmed is None or not RULES[track.reason].latched
    )


def findings(evidence: Evidence) -> tuple[Finding, ...]:
    """Confirmed symptoms, the most serious first."""
    return tuple(
        Finding(
            reason=track.reason,
            since=track.confirmed,
            stops=RULES[track.reason].stops,
            latched=RULES[track.reason].latched,
        )
        for track in evidence
        if track.confirmed is not None
    )


def _ended(track: Track, rule: Rule, time: float) -> bool:
    if track.confirmed is None:
        return time - track.last > _GAP
    if rule.latched:
        return False
    return time - track.last >= rule.release - 1e-9
