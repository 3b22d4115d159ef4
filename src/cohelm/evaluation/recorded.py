"""Rides that are recorded while they last."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from cohelm.evaluation.episode import Episode, Watcher
from cohelm.evaluation.ride import Ride
from cohelm.evaluation.scenario import Scenario
from cohelm.evaluation.staging import Stage, set_stage
from cohelm.evaluation.sweeps.identity import LIBRARIES, code
from cohelm.navigation import Tick
from cohelm.recordings import RideFacts, RideRecorder
from cohelm.simulation import Truth

_ONLY_RIDES = ("cli", "evaluation", "pictures", "recordings", "simulation", "testing")
"""Parts of cohelm that no command comes of, once it is known what was observed."""


def run_recorded(scenario: Scenario, seed: int, file: Path, on_tick: Watcher | None = None) -> Ride:
    """Ride a scenario and record it; the ride is the same as without.

    Args:
        scenario, seed, on_tick: as for :func:`~.episode.run`.
        file: an MCAP file, which must not exist; however the ride ends, what was recorded until
            then is kept.

    Raises:
        ConfigError, MapError, PluginError, PlanningError: see :func:`~.staging.set_stage`.
        RecordingError: if the file exists, cannot be written, or the disk takes no more.
    """
    stage = set_stage(scenario, seed)
    with RideRecorder(file, facts_of(stage)) as recorder:

        def watch(tick: Tick, truth: Truth) -> None:
            recorder(tick, truth)
            if on_tick is not None:
                on_tick(tick, truth)

        ride = Episode(stage).run(watch)
        recorder.end(ride.outcome.value)
    return ride


def facts_of(stage: Stage) -> RideFacts:
    """What a recording must know of a ride to be replayed anywhere."""
    return RideFacts(
        name=stage.scenario.name,
        seed=stage.seed,
        versions=ride_versions(),
        scenario=stage.scenario.model_dump(mode="json"),
        robot=stage.robot,
        grid=stage.navigator.grid,
        filters=stage.navigator.filters,
        heat=stage.navigator.heat,
    )


def ride_versions() -> Mapping[str, str]:
    """Versions of all that a command comes of, and digests of the code of cohelm that it does."""
    known = code()
    ours = [f"{name}={known[name]}" for name in sorted(known) if _decides(name)]
    digest = hashlib.sha256("\n".join(ours).encode()).hexdigest()[:16]
    return {name: known[name] for name in (*LIBRARIES, "python")} | {"code": digest}


def _decides(name: str) -> bool:
    """Whether a file of the code belongs to what a command comes of."""
    package, slash, rest = name.partition("/")
    return bool(slash) and (package != "cohelm" or rest.partition("/")[0] not in _ONLY_RIDES)
