"""Health monitor: redundant input compared, doubt and loss detected, each with a reason."""

from cohelm.health.map_changes import NO_CHANGES, MapChanges, updated_map
from cohelm.health.map_fit import SolidMap, beam_map
from cohelm.health.monitor import HealthState, acknowledged, monitor
from cohelm.health.parameters import HealthParameters
from cohelm.health.registration import registered
from cohelm.health.values import Finding, Health, LocalisationHealth, LocalisationState

__all__ = [
    "NO_CHANGES",
    "Finding",
    "Health",
    "HealthParameters",
    "HealthState",
    "LocalisationHealth",
    "LocalisationState",
    "MapChanges",
    "SolidMap",
    "acknowledged",
    "beam_map",
    "monitor",
    "registered",
    "updated_map",
]
