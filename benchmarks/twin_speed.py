"""Speed of the twin without navigator: thread CPU time of physics, sensors and the rest, one core.

    python benchmarks/twin_speed.py [PEOPLE] [SECONDS]

The hospital floor with a scanner of 360 beams at 10 Hz; the chair drives on a slow circle.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from cohelm.messages import Decision
from cohelm.platforms import open_simulation
from cohelm.platforms.twin import twin_chair
from cohelm.platforms.twin.twin_chair import BodyCasting
from cohelm.scenarios import build_scenario, load_scenario

SPENT = {"physics": 0.0, "sensors": 0.0}


def timed(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the thread CPU time of a function to a sum."""

    def wrapped(*args: Any, **kwargs: Any) -> Any:
        began = time.thread_time()
        try:
            return function(*args, **kwargs)
        finally:
            SPENT[name] += time.thread_time() - began

    return wrapped


class Timed:
    """MuJoCo's module with a timed step."""

    def __init__(self, mujoco: Any) -> None:
        self._mujoco = mujoco
        self.mj_step = timed("physics", mujoco.mj_step)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mujoco, name)


def main() -> None:
    """Print the sums."""
    people = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    scenario = load_scenario("hospital", [f"people.count={people}", "platform.use=twin"])
    platform, world = open_simulation(build_scenario(scenario, 0))
    chair: Any = platform.chair
    assert isinstance(chair, twin_chair.TwinChair)
    decision = Decision(twist=np.array([0.3, 0.0, 0.4]))
    for _ in range(20):  # compiles
        platform.apply(decision)
    chair._mujoco = Timed(chair._mujoco)
    BodyCasting.scan = timed("sensors", BodyCasting.scan)
    began, start = time.thread_time(), world.truth.time
    while world.truth.time < start + seconds:
        platform.observe()
        platform.apply(decision)
    total = time.thread_time() - began
    rest = total - sum(SPENT.values())
    print(f"{people} people, {chair.twin.model.ngeom} geometries, {chair.twin.model.nv} freedoms")
    for name, spent in {**SPENT, "people, riders, gaps, the rest": rest, "all": total}.items():
        factor = seconds / spent
        print(f"{name}: {1e3 * spent / seconds:.1f} ms per second, {factor:.0f} x real time")


if __name__ == "__main__":
    main()
