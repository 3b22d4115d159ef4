"""Families of scenes in which rider and chair know different things; fixed before the rides."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from cohelm.errors import ScenarioError
from cohelm.scenarios.scenario import load_scenario
from cohelm.simulation import generator

HANDS = ("ideal", "tremor", "eight_directions", "noisy")
"""Riders of the families in which the chair lacks knowledge."""
REAL_HANDS = ("tremor", "one_switch", "eight_directions", "biased", "noisy")
"""Riders of the crossed study: hands that are difficult in themselves."""
SPLIT = ("unseen", "old-map", "goal", "way")
"""Families of the crossed study: the rider knows what the chair does not."""
SHIFT = 0.15
"""Largest sideways shift of a start, m."""
TURN = 5.0
"""Largest turn of a start, degrees."""
FAST = 0.5
"""Speed above which a collision is counted as a fast one, m/s."""


def beside_start(scenario: str, seed: int) -> tuple[str, ...]:
    """Setting that starts a scenario beside its usual start, the same for all riders and modes.

    Raises:
        ScenarioError: if the scenario has no heading at its start.
    """
    start = load_scenario(scenario).start
    if isinstance(start, str) or len(start) != 3:
        raise ScenarioError("must be [x, y, degrees] for this benchmark", key="start")
    x, y, degrees = start
    shift, turn = generator(seed, "start").uniform(-1.0, 1.0, 2)
    shift, turn = SHIFT * float(shift), TURN * float(turn)
    heading = math.radians(degrees)
    pose = (x - shift * math.sin(heading), y + shift * math.cos(heading), degrees + turn)
    return (f"start=[{', '.join(f'{each:.4f}' for each in pose)}]",)


@dataclass(frozen=True)
class SplitFamily:
    """Scenes in which the same kind of knowledge is on one side only."""

    title: str
    rider_knows: str
    chair_knows: str
    scenes: Mapping[str, tuple[str, ...]]
    """Scenario → its riders."""


def _scenes(*names: str) -> Mapping[str, tuple[str, ...]]:
    return dict.fromkeys(names, HANDS)


FAMILIES: Mapping[str, SplitFamily] = {
    "unseen": SplitFamily(
        title="the chair cannot see it",
        rider_knows="glass, a table's top, a person in the dead sector, a wet floor",
        chair_knows="the map and the goal",
        scenes=_scenes("glass-box", "glass-bench", "table-overhang", "dead-sector", "wet-floor"),
    ),
    "old-map": SplitFamily(
        title="the map is old",
        rider_knows="a new wall, a moved door",
        chair_knows="the map as it was, the goal, and what its sensors see",
        scenes=_scenes("new-wall", "moved-door"),
    ),
    "goal": SplitFamily(
        title="the chair does not know the goal",
        rider_knows="where to go now",
        chair_knows="the former goal, or none",
        scenes=_scenes("new-goal", "untold-goal"),
    ),
    "way": SplitFamily(
        title="the rider wants another way",
        rider_knows="a place to come past",
        chair_knows="the goal and the shortest way",
        scenes=_scenes("past-a-friend", "along-the-window"),
    ),
    "hands": SplitFamily(
        title="the rider cannot steer or does not look",
        rider_knows="the goal",
        chair_knows="the map, the goal, and all that its sensors see",
        scenes={
            "corridor-1": ("tremor", "one_switch"),
            "room-door": ("tremor", "one_switch"),
            "people-cross": ("looks_away",),
        },
    ),
}
"""Name of a family → its definition."""
