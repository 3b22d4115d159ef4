"""Narrow doorways among people, with hands of all kinds: how many get through, and whom they touch.

A door of 0.76 or 0.84 m for a chair of 0.61 m; a person comes through it the other way, or people
stand beside it. A seed moves and turns the start, and draws people, sensor noise and the hand.
"""

from __future__ import annotations

from functools import partial

from cohelm import plugins
from cohelm.benchmarks.bench import chosen_names, unset
from cohelm.benchmarks.claims import NONE, Bound
from cohelm.benchmarks.options import Modes, Riders, Settings
from cohelm.benchmarks.ride_claims import Requirement
from cohelm.benchmarks.rides.modes import (
    ALL_RIDES,
    WITHOUT_DESTINATION,
    Experiment,
    modes_of,
    modes_report,
    riders_of,
)
from cohelm.benchmarks.rides.sharing_families import beside_start
from cohelm.benchmarks.study import Grid, Study, Variant, common, ride_all

SCENES = ("doorway-oncoming", "doorway-standing")
RIDERS = ("one_switch", "eight_directions", "ideal", "tremor")
WIDTHS = (0.76, 0.84)
"""Widths of the door, m, on whole cells of the scenes."""
DOORWAYS = Experiment(
    title="Narrow doorways among people",
    claims=(
        Requirement("reached", Bound(low=0.9), (ALL_RIDES,), "assisted"),
        Requirement("reached", Bound(low=0.9), ("rider *",), "assisted"),
        Requirement("fast_contacts", NONE, (ALL_RIDES,), "assisted"),
    ),
    scenes=SCENES,
    seeds=5,
)
COMPARED = {
    "rider": "--riders",
    "mode": "--modes",
    "start": "the seed",
    "floor_plan.doors.0.width": "the benchmark, which rides several widths",
}
"""Keys that cannot be set for all rides → what sets them."""


def create(riders: Riders = None, modes: Modes = None, settings: Settings = ()) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, ScenarioError: if a rider, a mode or a setting does not exist.
    """
    unset(settings, COMPARED)
    known = tuple(name for name in plugins.names("riders") if name not in WITHOUT_DESTINATION)
    hands = chosen_names(riders, "--riders", RIDERS, kind="rider", known=known)
    doors = tuple(
        Variant(
            columns=(("scene", f"{scene}, {width:.2f} m"),),
            settings=(f"floor_plan.doors.0.width={width}",),
            scenario=scene,
            drawn=partial(beside_start, scene),
        )
        for scene in SCENES
        for width in WIDTHS
    )
    return Study(
        DOORWAYS.title,
        Grid((doors, common(settings), riders_of(hands), modes_of(modes))),
        partial(modes_report, experiment=DOORWAYS),
        partial(ride_all, empty_floor=False),
        SEEDS=DOORWAYS.seeds,
    ).checked("rider")
