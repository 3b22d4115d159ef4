"""Compilation of all kernels that rides need, without a chair that waits for them."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from cohelm.evaluation import measure, run
from cohelm.live.control.navigator_process import warm_up
from cohelm.live.control.world_factory import build_world
from cohelm.live.page import preview_process
from cohelm.live.page.floor_model import floor_model
from cohelm.scenarios import load_scenario

FLOOR, RIDE = "hospital", "crossing"
"""Scenarios of ``cohelm drive`` and of the examples of ``cohelm run``."""


def compile_kernels() -> Iterator[str]:
    """Run everything that a ride with the default parts needs, so that it is compiled and cached.

    Yields:
        Name of the next part.
    """
    usual = gc.get_threshold()
    gc.set_threshold(200_000, 20, 100)  # most new objects stay: visiting them takes a tenth of it
    try:
        yield "floor"
        scenario = load_scenario(FLOOR)
        floor_model(scenario, 0)
        yield "world"
        world = build_world(scenario, 0)
        for case in warm_up(world.ride_setup):
            yield f"navigator, {case}"
        yield "route previews"
        preview_process.warm_up(world.ride_setup)
        yield "measures"
        measure(run(load_scenario(RIDE, ["time_limit=6"]), 0))
    finally:
        gc.set_threshold(*usual)


class Compilations(event.Listener):
    """Number of kernels of cohelm that were compiled rather than loaded, while it listens.

    Args:
        report: Called with the number before each compilation.
    """

    def __init__(self, report: Callable[[int], None] = lambda number: None) -> None:
        self._report = report
        self.number = 0
        self.seconds = 0.0
        """Total time of compilation, s."""
        self._depth = 0
        self._began = 0.0

    def on_start(self, event: Any) -> None:
        """Count a compilation; those of its callees lie within it."""
        if self._depth == 0:
            self._began = time.monotonic()
        self._depth += 1
        if event.data["dispatcher"].py_func.__module__.startswith("cohelm."):
            self.number += 1
            self._report(self.number)

    def on_end(self, event: Any) -> None:
        """Add the time."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.monotonic() - self._began

    @contextmanager
    def listening(self) -> Iterator[Compilations]:
        """Listen within a block."""
        event.register("numba:compile", self)  # type: ignore[no-untyped-call] # as below
        try:
            yield self
        finally:
            event.unregister("numba:compile", self)  # type: ignore[no-untyped-call] # numba's
