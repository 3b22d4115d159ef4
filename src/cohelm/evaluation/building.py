"""The floor of a scenario as it is drawn: its file's, with what the scenario has otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cohelm.config import read_yaml, validate
from cohelm.errors import ScenarioError
from cohelm.evaluation.scenario import Scenario, floor_file
from cohelm.maps import FloorPlan
from cohelm.simulation import Doorway

WIDEST = 2.5
"""An opening that is wider has no door, m."""


def floor_plan(scenario: Scenario) -> FloorPlan:
    """The plan of a scenario's floor with the scenario's ``plan`` put in.

    Raises:
        ScenarioError: if the scenario names no floor that there is, or what it changes is not so.
    """
    if scenario.floor is None:
        raise ScenarioError(
            "only a floor: has a plan; this scenario has a map:", file=scenario.file, key="plan"
        )
    file = floor_file(scenario.floor)
    data = _merged(read_yaml(file, error=ScenarioError), scenario.plan, scenario, "plan")
    named = scenario.file if scenario.plan else file
    plan = validate(FloorPlan, data, file=named, prefix="plan", error=ScenarioError)
    return plan.model_copy(update={"source": str(named)})


def doorways(plan: FloorPlan) -> tuple[Doorway, ...]:
    """Where a floor has doors that can be shut; a leaf is as thick as the wall."""
    wide = [door.width <= WIDEST for door in plan.doors]
    ends = plan.openings[np.array(wide, dtype=bool)]
    return tuple(Doorway(a=a, b=b, depth=plan.wall) for a, b in ends)


def _merged(there: Any, other: Any, scenario: Scenario, key: str) -> Any:
    """``there`` with ``other`` put in: mappings key by key, list entries by their number."""
    if isinstance(there, Mapping) and isinstance(other, Mapping):
        out = dict(there)
        for name, each in other.items():
            below = f"{key}.{name}"
            out[name] = _merged(there[name], each, scenario, below) if name in there else each
        return out
    if isinstance(there, list) and isinstance(other, Mapping):
        entries = list(there)
        for name, each in other.items():
            if not str(name).isdecimal() or int(name) >= len(entries):
                raise ScenarioError(
                    f"there are {len(entries)}: write a number below that",
                    file=scenario.file,
                    key=f"{key}.{name}",
                )
            at = int(name)
            entries[at] = _merged(entries[at], each, scenario, f"{key}.{name}")
        return entries
    return other
