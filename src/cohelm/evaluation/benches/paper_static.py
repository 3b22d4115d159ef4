"""The static experiment of Xu et al., Fig. 13: narrow corridors, ridden by hand, alone and shared.

The paper's people rode; here simulated riders do, each with the same seeds in every mode. What it
calls shared control is ``shared``; ``assisted`` is the rider alone behind the safety gate. Nobody
was asked for their satisfaction: effort and agreement are stand-ins, and named so.
"""

from __future__ import annotations

from functools import partial

from cohelm.evaluation.benches.steering import Experiment, steered

EXPERIMENT = Experiment(
    title="The paper's corridors by hand, assisted, shared and alone (Xu et al., Fig. 13)",
    asks="paper",
    scenes=("corridor-1", "corridor-2", "corridor-3", "corridor-4"),
    seeds=5,
)
"""Each scene has something on its centre line or nearly, and a turn in at most 1.3 m."""

on = partial(steered, EXPERIMENT)
"""The benchmark as options ask for it, see :func:`~cohelm.evaluation.benches.steering.steered`."""
