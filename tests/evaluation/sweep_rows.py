"""Rows and curves like those of rides, without riding."""

from __future__ import annotations

import numpy as np

from cohelm.benchmarks.bench import Result

PLANNERS = ("ours", "dwa", "teb")
SCENES = ("crossing", "aggressive")


def result(scene="crossing", planner="ours", seed=0, **changes):
    """One ride along x at 0.7 m/s that reached its goal, with whatever is changed of its row."""
    row = {
        "scene": scene,
        "planner": planner,
        "seed": seed,
        "outcome": "reached",
        "time_empty_floor": 10.0,
        "collision_speed": np.nan,
        "time": 12.0,
        "path_length": 10.0,
        "min_distance": 0.5,
        "collisions_person": 0.0,
        "collisions_wall": 0.0,
        "standing_contacts": 0.0,
        "agreement": np.nan,
        "people_source": "tracker",
        "config": "c0ffee",
        "version": "0.1.0",
        "error": "",
        "traceback": "",
        "replay": "",
        **changes,
    }
    time = np.arange(0.0, 12.0, 0.2)
    rest = np.zeros((len(time), 2))
    curve = np.column_stack(
        [time, 0.7 * time, np.sin(time + seed), rest, np.sin(time), 1.0 + rest[:, 0], rest[:, 0]]
    )
    return Result(row, {} if row["outcome"] == "error" else {"series": curve})


def sweep(seeds=12, planners=PLANNERS, scenes=SCENES, later=0.0, rng_seed=0):
    """Every planner in every scene on every seed; ``later``: how much longer all take, s."""
    rng = np.random.default_rng(rng_seed)
    out = []
    for seed in range(seeds):
        for scene in scenes:
            hard = rng.normal()
            for k, planner in enumerate(planners):
                time = 12.0 + hard + 0.8 * k + 0.1 * rng.normal() + later
                out.append(result(scene, planner, seed, time=time, min_distance=rng.uniform()))
    return out
