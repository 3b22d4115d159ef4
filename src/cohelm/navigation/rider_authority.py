"""Authority of the rider in one step: the stick, its weight η, and where the chair takes over."""

from __future__ import annotations

import dataclasses

from cohelm import sharing
from cohelm.messages import Authority, Mode
from cohelm.navigation.recovery.stages import RecoveryAction
from cohelm.navigation.tick import StepInput
from cohelm.sharing import AuthorityState


def rider_authority(step: StepInput) -> tuple[Authority, AuthorityState]:
    """Compute the rider's input and its weight η."""
    setup = step.setup
    return sharing.authority(
        step.observation,
        step.request.profile,
        setup.robot,
        horizon=sharing.InputHorizon(
            steps=setup.local_planner.steps, step=setup.local_planner.step
        ),
        speed_limit=setup.speed_limit(step.request),
        memory=step.memory.authority,
        parameters=setup.authority,
    )


def limited_authority(step: StepInput, authority: Authority, recovery: RecoveryAction) -> Authority:
    """Reduce η where the chair takes over: during recovery and at the end of the path."""
    route, parameters = step.memory.route, step.setup.authority
    if step.request.mode is not Mode.SHARED or route is None:
        return authority
    if recovery.takes_over:
        # A chair at rest must not set off against a stick that is pulled back.
        if authority.deflection[0] <= -parameters.stop_deflection:
            return authority
        return dataclasses.replace(authority, eta=0.0)
    if authority.yields:
        return authority
    return sharing.limit_authority(authority, route.path.length - route.progress, parameters)
