"""Requirements of norms for wheelchair users, beside the values measured in a building.

Clauses are those of the 2010 ADA Standards for Accessible Design; those of ISO 21542 are not given.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from cohelm.arrays import value

_ADA, _ISO = "2010 ADA Standards", "ISO 21542:2021 (clause not given)"


class NormRule(NamedTuple):
    """Limit of a norm for one measure."""

    norm: str
    clause: str
    says: str
    measure: str
    """Key of the measured values."""
    limit: float
    """m; 0 where the model has no data to compare."""
    at_least: bool = True
    """False: the limit is a maximum."""
    sure: float = 0.0
    """Values from the limit up to this one are undecided, m."""


_IN = 0.0254  # m; the inches of the ADA Standards are exact, their millimetres rounded
RULES = (
    NormRule(_ADA, "404.2.3", "clear width of doors at least 32 in (815 mm)", "door", 32 * _IN),
    NormRule(_ISO, "", "clear width of doors at least 800 mm", "door", 0.80),
    NormRule(
        _ADA, "404.2.4", "manoeuvring clearance at doors: depth 42 to 60 in (1065 to 1525 mm), "
        "by approach", "approach", 42 * _IN, sure=60 * _IN,
    ),
    NormRule(
        _ADA, "404.2.5", "thresholds at most 1/2 in (13 mm)", "threshold", 0.013, at_least=False
    ),
    NormRule(
        _ADA, "304.3.1", "turning space of 60 in (1525 mm) diameter", "turning", 60 * _IN
    ),
    NormRule(_ISO, "", "turning space of 1500 mm diameter", "turning", 1.50),
    NormRule(
        _ADA, "403.5.1", "clear width of walking surfaces at least 36 in (915 mm), or 32 in "
        "(815 mm) for at most 24 in (610 mm) of length", "route", 32 * _IN, sure=36 * _IN,
    ),
    NormRule(_ADA, "405.2", "slope of ramps at most 1:12", "ramp", 0.0),
    NormRule(_ADA, "405.5", "clear width of ramps at least 36 in (915 mm)", "ramp", 0.0),
    NormRule(
        _ADA, "407.4.1", "lift car at least 54 in (1370 mm) wide, up to 80 in (2030 mm) by its "
        "door", "car width", 54 * _IN, sure=80 * _IN,
    ),
    NormRule(
        _ADA, "407.4.1", "lift car at least 51 in (1295 mm) deep, up to 80 in (2030 mm) by its "
        "width", "car depth", 51 * _IN, sure=80 * _IN,
    ),
    NormRule(_ISO, "", "lift car at least 1100 mm wide", "car width", 1.10),
    NormRule(_ISO, "", "lift car at least 1400 mm deep", "car depth", 1.40),
)  # fmt: skip


class MeasuredValue(NamedTuple):
    """Value that a norm limits."""

    place: str
    value: float | None
    """m; None: no data."""
    error: float = 0.0
    """The true value is up to this much larger, m: maps are never wider than the building."""


@value
class NormCheck:
    """Values of a building compared with one rule."""

    rule: NormRule
    passes: int
    unknown: int
    failures: tuple[str, ...]
    """Place and value of each failure."""


def check_norms(measured: Mapping[str, Iterable[MeasuredValue]]) -> tuple[NormCheck, ...]:
    """Compare measured values, by the key of their measure, with every rule that has any."""
    checks = []
    for rule in RULES:
        verdicts = [(each, _verdict(rule, each)) for each in measured.get(rule.measure, ())]
        counts = Counter(verdict for _, verdict in verdicts)
        failures = (f"{e.place}: {e.value:.3f} m" for e, verdict in verdicts if verdict == "fails")
        if verdicts:
            checks.append(
                NormCheck(
                    rule=rule, passes=counts["passes"], unknown=counts["unknown"],
                    failures=tuple(failures),
                )
            )  # fmt: skip
    return tuple(checks)


def _verdict(rule: NormRule, each: MeasuredValue) -> str:
    """``passes``, ``fails``, or ``unknown`` where data are missing or too coarse."""
    if each.value is None or not rule.limit:
        return "unknown"
    if not rule.at_least:
        return "passes" if each.value <= rule.limit + 1e-6 else "fails"
    if each.value + each.error < rule.limit - 1e-4:
        return "fails"
    return "passes" if each.value >= max(rule.limit, rule.sure) - 1e-4 else "unknown"
