"""Views of a chair, and the inputs of riders to them."""

import numpy as np

from cohelm.plugins import build
from cohelm.simulation.api import RiderView

STEP = 0.05
ROUTE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 5.0]])


def view(time, pose=(0.0, 0.0, 0.0), speed=0.0, **more):
    fields = {"goal": ROUTE[-1], "route": ROUTE}
    return RiderView(
        time=time,
        pose=np.array(pose, dtype=float),
        twist=np.array([speed, 0.0, 0.0]),
        **{**fields, **more},
    )


def swaying(count):
    """Views from a chair that sways, so that a good hand never does the same twice."""
    times = STEP * np.arange(count)
    return [
        view(t, (2.0 + np.sin(0.05 * t), 0.3 * np.sin(0.9 * t), 0.4 * np.cos(1.1 * t)))
        for t in times
    ]


def acts(spec, views, seed=0):
    rider, rng, memory, out = build("riders", spec), np.random.default_rng(seed), None, []
    for each in views:
        act = rider.act(each, memory, rng)
        memory = act.memory
        out.append(act.command)
    return out


def pushes(spec, views, seed=0):
    return np.array([command.deflection for command in acts(spec, views, seed)])
