"""Ten riders in four modes and five scenes: who can ride with this chair, and at what cost.

Every rider rides the same seeds by hand, assisted, shared and alone. In ``distracted`` the moment
of the turn is swept over the seeds, see ``rides_scenes``.
"""

from __future__ import annotations

from functools import partial

from cohelm.evaluation.benches.steering import Experiment, steered

EXPERIMENT = Experiment(
    title="Riders of all kinds by hand, assisted, shared and alone",
    asks="limits",
    scenes=("corridor-1", "corridor-4", "crossing", "distracted", "talking"),
    seeds=10,
)
on = partial(steered, EXPERIMENT)
"""The benchmark as options ask for it, see :func:`~cohelm.evaluation.benches.steering.steered`."""
