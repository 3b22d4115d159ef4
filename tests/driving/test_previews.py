"""What a wish would cost is known at once, the first time too."""

import gc
import pickle

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from cohelm.driving import previews
from cohelm.evaluation import load_scenario
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Crowding, LiveObstacles, Wish


@pytest.fixture(scope="module")
def stage():
    return set_stage(load_scenario("hospital"), 0)


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


def test_nothing_is_left_to_compile_once_it_is_warm(stage):
    """Neither for a place far off the way nor for a line or a zone, among things and people."""
    previews._warm(stage)
    before, start = compiled(), stage.route.points[0]
    far = max((place.point for place in stage.places), key=lambda at: np.hypot(*(at - start)))
    middle = stage.route.points[len(stage.route.points) // 2]
    wishes = (
        Wish(points=np.array([far])),
        Wish(kind="stroke", points=np.array([middle - 1.0, middle + 1.0])),
        Wish(kind="avoid", points=np.array([middle - 0.5, middle + 0.5]), radius=0.3),
    )
    for surroundings in (about(stage), about(stage, **things_and_people(stage))):
        for number, wish in enumerate(wishes):
            asked = previews.WhatIf(id=number, client="a", wish=wish, surroundings=surroundings)
            told = previews.price(asked, stage)
            assert (told.id, told.client) == (number, "a")
            assert told.trouble or told.length > 1.0
    assert compiled() - before == set()
