"""What prices of wishes still have to compile, in a process that has compiled nothing else."""

import gc
import pickle

import numpy as np
from numba.core.dispatcher import Dispatcher

from cohelm.driving import previews
from cohelm.evaluation import load_scenario
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Crowding, LiveObstacles, Wish


def about(stage, **changes):
    """What is about a chair at the start, asked for where it was to go."""
    start = stage.route.points[0]
    found = {
        "pose": np.array([*start, 0.0]),
        "goal": stage.request.goal,
        "wishes": (),
        "wished_from": start,
        "clearance": stage.request.profile.clearance,
        "live": None,
        "crowding": None,
    }
    return pickle.dumps(previews.Surroundings(**{**found, **changes}))


def compiled():
    """Kernels and the kinds of arguments that they are ready for."""
    kernels = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return {
        (kernel.py_func.__qualname__, signature)
        for kernel in kernels
        if kernel.py_func.__module__.startswith("cohelm.")
        for signature in kernel.signatures
    }


def things_and_people(stage):
    corner = stage.grid.cells(stage.route.points[0]) - 50
    occupied = (np.random.default_rng(3).random((90, 110)) < 0.002).astype(np.uint8)
    occupied[20:80, 20:80] = 0  # not on the chair
    density = np.random.default_rng(4).random((9, 7), dtype=np.float32)
    return {
        "live": LiveObstacles(corner=corner, occupied=occupied, version=7),
        "crowding": Crowding(density=density, resolution=0.5, X_MG=np.zeros(3), version=9),
    }


def priced():
    """(prices as (length, trouble), kernels that the first of them had to compile) once warm."""
    stage = set_stage(load_scenario("hospital"), 0)
    previews._warm(stage)
    before, start = compiled(), stage.route.points[0]
    far = max((place.point for place in stage.places), key=lambda at: np.hypot(*(at - start)))
    middle = stage.route.points[len(stage.route.points) // 2]
    wishes = (
        Wish(points=np.array([far])),
        Wish(kind="stroke", points=np.array([middle - 1.0, middle + 1.0])),
        Wish(kind="avoid", points=np.array([middle - 0.5, middle + 0.5]), radius=0.3),
    )
    prices = []
    for surroundings in (about(stage), about(stage, **things_and_people(stage))):
        for wish in wishes:
            asked = previews.WhatIf(id=1, client="a", wish=wish, surroundings=surroundings)
            told = previews.price(asked, stage)
            prices.append((told.length, told.trouble))
    return prices, sorted(name for name, _ in compiled() - before)
