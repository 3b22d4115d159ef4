"""Yielding in shared mode: its state from the last plan, and the motion that the rider asks for."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import Authority, Mode
from cohelm.navigation.recovery.context import is_standing_still
from cohelm.navigation.tick import StepInput, Tick
from cohelm.sharing import RiderIntent, YieldingState, update_yielding


def with_yielding(
    step: StepInput, authority: Authority, last: Tick | None
) -> tuple[Authority, YieldingState | None]:
    """Decide whether the chair yields to the rider; only in shared mode.

    Args:
        step: input of the step.
        authority: of the rider.
        last: the previous tick, whose plan reports how far the chair's own choice deviates.

    Returns:
        The authority, and the disagreement to remember.
    """
    if step.request.mode is not Mode.SHARED:
        return authority, None
    plan = last.plan if last else None
    state = update_yielding(
        step.observation.time,
        np.nan if plan is None else plan.disagreement,
        step.memory.yielding,
        step.setup.yielding,
        deflected=bool(authority.deflection.any()),
        stands=is_standing_still(step.observation.twist),
        docking=_docking(step),
    )
    return dataclasses.replace(authority, yields=state.yields), state


def rider_inputs(authority: Authority, intent: RiderIntent) -> Floats | None:
    """Inputs of the motion that the rider asks for; None for a rider who leaves it to the chair.

    A rider to whom the chair yields asks to stand by letting go.
    """
    asks = authority.yields or bool(authority.deflection.any())
    return intent.inputs if asks else None


def _docking(step: StepInput) -> float:
    """Share to which η has faded near the goal."""
    route, distance = step.memory.route, step.setup.authority.docking_distance
    if route is None or distance <= 0.0:
        return 1.0
    return min(max((route.path.length - route.progress) / distance, 0.0), 1.0)
