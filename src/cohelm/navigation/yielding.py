"""Yielding in shared mode: the disagreement of rider and chair, and where it is measured."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.messages import Authority, LocalPlan, Mode
from cohelm.navigation.standstill import is_standing_still
from cohelm.navigation.tick import StepInput
from cohelm.sharing import RiderIntent, YieldingState, update_yielding


def with_yielding(step: StepInput, authority: Authority) -> tuple[Authority, YieldingState | None]:
    """Decide whether the chair yields to the rider; only in shared mode.

    Args:
        step: input of the step.
        authority: of the rider.

    Returns:
        The authority, and the disagreement to remember.
    """
    if step.request.mode is not Mode.SHARED:
        return authority, None
    memory = step.memory.yielding
    state = update_yielding(
        step.observation.time,
        np.nan if memory is None else memory.measured,
        memory,
        step.setup.yielding,
        deflected=bool(authority.deflection.any()),
        stands=is_standing_still(step.observation.twist),
        docking=_docking(step),
    )
    return replace(authority, yields=state.yields), state


def rider_inputs(authority: Authority, intent: RiderIntent) -> Floats | None:
    """Inputs of the motion that the rider asks for; None for a rider who leaves it to the chair."""
    return intent.inputs if authority.deflection.any() else None


def with_disagreement(state: YieldingState | None, plan: LocalPlan | None) -> YieldingState | None:
    """State with the disagreement of rider and plan, rad, as the plan of this tick reports it."""
    if state is None or plan is None:
        return state
    return replace(state, measured=plan.disagreement)


def _docking(step: StepInput) -> float:
    """Share to which η has faded near the goal."""
    route, distance = step.memory.route, step.setup.authority.docking_distance
    if route is None or distance <= 0.0:
        return 1.0
    return min(max((route.path.length - route.progress) / distance, 0.0), 1.0)
