"""Rides that are ridden again: the command in a row says all that they need."""

from __future__ import annotations

import shlex

from cohelm.evaluation.results.rides import Row
from cohelm.evaluation.sweeps.ride_task import RideTask

_AS_SETTING = {"--planner": "local_planner.use", "--rider": "rider.use", "--mode": "mode"}


def task_of(row: Row) -> RideTask | None:
    """The ride of a row by its ``replay`` command; None where there is none that can be read."""
    try:
        words = shlex.split(str(row.get("replay") or ""))
    except ValueError:
        return None
    if words[:2] != ["cohelm", "run"] or len(words) % 2 == 0:
        return None
    seed, settings = 0, []
    for option, given in zip(words[3::2], words[4::2], strict=True):
        if option == "--seed" and given.isdecimal():
            seed = int(given)
        elif option == "--set":
            settings.append(given)
        elif option in _AS_SETTING:
            settings.append(f"{_AS_SETTING[option]}={given}")
        else:
            return None
    return RideTask(columns=(), scenario=words[2], settings=tuple(settings), seed=seed)
