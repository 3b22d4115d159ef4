"""Rides with a stick that a test moves."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.maps import write_map
from cohelm.messages import RiderCommand
from cohelm.navigation import Navigator
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing.scenes import room, walkers


@pytest.fixture
def drive(tmp_path):
    """Ticks and truths of a ride with a stick and without a destination."""

    def run(seconds, stick, *, boxes=(), people=lambda t: [], start=(3.0, 4.0, 0.0), **keys):
        write_map(room(boxes=boxes), tmp_path / "room.yaml")
        scenario = {
            "map": str(tmp_path / "room.yaml"),
            "start": list(start),
            "goal": [10.5, 4.0],
            "mode": "assisted",
            "tracker": "given",
            **keys,
        }
        file = tmp_path / "ride.yaml"
        file.write_text("\n".join(f"{key}: {value}" for key, value in scenario.items()))
        stage = build_scenario(load_scenario(file), 0)
        request = replace(stage.request, goal=np.full(2, np.nan))
        world, navigator, tick = World(stage.world, 0), Navigator(stage.navigator), None
        ticks, truths = [], []
        while world.truth.time < seconds:
            time = world.truth.time
            them = walkers(people(time), time=time, source="given")
            rider = RiderCommand(heartbeat=time, deflection=np.array(stick(time)))
            tick = navigator.step(replace(world.observe(), people=them, rider=rider), request, tick)
            ticks.append(tick)
            truths.append(world.truth)
            world.advance(tick.decision)
        return ticks, truths

    return run
