"""Rides with a recording."""

from __future__ import annotations

from pathlib import Path

from cohelm.evaluation.code_version import navigation_versions
from cohelm.evaluation.episode.episode import Episode, Watcher
from cohelm.evaluation.episode.ride import Ride
from cohelm.navigation import Tick
from cohelm.recordings import RideFacts, RideRecorder
from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.scenario import Scenario
from cohelm.simulation import GroundTruth


def run_recorded(scenario: Scenario, seed: int, file: Path, on_tick: Watcher | None = None) -> Ride:
    """Run a ride of a scenario and record it; the ride equals one without a recording.

    Args:
        scenario, seed, on_tick: as for :func:`~.episode.run`.
        file: an MCAP file, which must not exist; it is complete up to the end of the ride, also
            after an error.

    Raises:
        ConfigError, MapError, PluginError, PlanningError: see ``build_scenario``.
        RecordingError: if the file exists, cannot be written, or the disk takes no more.
    """
    setup = build_scenario(scenario, seed)
    with RideRecorder(file, facts_of(setup)) as recorder:

        def watch(tick: Tick, truth: GroundTruth) -> bool | None:
            recorder(tick, truth)
            return on_tick(tick, truth) if on_tick is not None else None

        ride = Episode(setup).run(watch)
        recorder.end(ride.outcome.value)
    return ride


def facts_of(setup: RideSetup) -> RideFacts:
    """Facts of a ride that a recording needs to be replayed anywhere."""
    return RideFacts(
        name=setup.scenario.name,
        seed=setup.seed,
        versions=navigation_versions(),
        scenario=setup.scenario.model_dump(mode="json"),
        robot=setup.robot,
        grid=setup.navigator.grid,
        filters=setup.navigator.filters,
        heat=setup.navigator.heat,
    )
