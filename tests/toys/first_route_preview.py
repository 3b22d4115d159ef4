"""What routes with wishes still have to compile, in a process that has compiled nothing else."""

import gc
import pickle

import numpy as np
from numba.core.dispatcher import Dispatcher

from cohelm.live.page import preview_process as previews
from cohelm.messages import LiveObstacles, Wish
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario


def about(ride_setup, **changes):
    """What is about a chair at the start, asked for where it was to go."""
    start = ride_setup.route.points[0]
    found = {
        "pose": np.array([*start, 0.0]),
        "clearance": ride_setup.request.profile.clearance,
        "speed": ride_setup.request.profile.preferred_speed,
        "live": None,
    }
    return pickle.dumps(previews.PlanningContext(**{**found, **changes}))


def compiled():
    """Kernels and the kinds of arguments that they are ready for."""
    kernels = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return {
        (kernel.py_func.__qualname__, signature)
        for kernel in kernels
        if kernel.py_func.__module__.startswith("cohelm.")
        for signature in kernel.signatures
    }


def things(ride_setup):
    corner = ride_setup.grid.cells(ride_setup.route.points[0]) - 50
    occupied = (np.random.default_rng(3).random((90, 110)) < 0.002).astype(np.uint8)
    occupied[20:80, 20:80] = 0  # not on the chair
    return {
        "live": LiveObstacles(corner=corner, occupied=occupied, version=7),
    }


def priced():
    """(prices as (length, trouble), kernels that the first of them had to compile) once warm."""
    ride_setup = build_scenario(load_scenario("hospital"), 0)
    previews.warm_up(ride_setup)
    before, start = compiled(), ride_setup.route.points[0]
    far = max((place.point for place in ride_setup.places), key=lambda at: np.hypot(*(at - start)))
    middle = ride_setup.route.points[len(ride_setup.route.points) // 2]
    wishes = (
        Wish(points=np.array([far])),
        Wish(kind="stroke", points=np.array([middle - 1.0, middle + 1.0])),
        Wish(kind="avoid", points=np.array([middle - 0.5, middle + 0.5]), radius=0.3),
    )
    goal = tuple(ride_setup.request.goal.tolist())
    prices = []
    for planning_context in (about(ride_setup), about(ride_setup, **things(ride_setup))):
        for wish in wishes:
            asked = previews.TripRequest(
                id=1, client="a", goal=goal, wishes=(wish,), planning_context=planning_context
            )
            *_, told = previews.trip_answers(asked, ride_setup)
            prices.append((told.routes[0].length, told.error))
    return prices, sorted(name for name, _ in compiled() - before)
