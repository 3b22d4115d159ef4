"""Topics of a bag that repeat another one: filtered, throttled or relayed copies of readings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

_SHARED = 0.5
"""Minimum share of a topic's times that the other one has, too."""


@dataclass(slots=True)
class TopicReadings:
    """Scans or clouds on one topic."""

    type: str
    frame: str
    sector: tuple[float, float]
    """First and last direction of a scan, rad."""
    times: set[float] = field(default_factory=set)
    size: int = 0
    """Size of all messages, bytes."""

    @classmethod
    def of(cls, type_: str, reading: Any) -> TopicReadings:
        """Record for the topic of a LaserScan or PointCloud2."""
        ends = (getattr(reading, f"angle_{end}", math.inf) for end in ("min", "max"))
        low, high = sorted(map(float, ends))
        return cls(type_, reading.header.frame_id, (-high if math.isinf(low) else low, high))

    def repeats(self, other: TopicReadings) -> bool:
        """Check that another topic has readings of the same sensor at the same times."""
        return (
            (self.type, self.frame) == (other.type, other.frame)
            and max(self.sector[0], other.sector[0]) < min(self.sector[1], other.sector[1])
            and len(self.times & other.times) >= _SHARED * len(self.times)
        )


def duplicates(sources: Mapping[str, TopicReadings]) -> dict[str, str]:
    """Topics that repeat another one, with that one, which has the most messages and bytes."""
    kept: list[str] = []
    found: dict[str, str] = {}
    order = {topic: (-len(s.times), -s.size, len(topic), topic) for topic, s in sources.items()}
    for topic in sorted(sources, key=order.__getitem__):
        whole = next((name for name in kept if sources[topic].repeats(sources[name])), None)
        if whole is None:
            kept.append(topic)
        else:
            found[topic] = whole
    return found
