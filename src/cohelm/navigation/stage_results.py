"""Results of all stages of one step, and the tick that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from cohelm.arrays import replace
from cohelm.health import Health, HealthState, acknowledged
from cohelm.messages import (
    Authority,
    Decision,
    DestinationBelief,
    Observation,
    People,
    Reason,
    Request,
)
from cohelm.navigation.destination_inference import DestinationState
from cohelm.navigation.motion import Motion
from cohelm.navigation.recovery.context import RecoveryUpdate
from cohelm.navigation.tick import Memory, StepInput, Tick
from cohelm.navigation.world_model import WorldModel
from cohelm.navigation.yielding import with_disagreement
from cohelm.safety import GateState, stop
from cohelm.sharing import AuthorityState, YieldingState


class CheckedInput(NamedTuple):
    """Input that is trusted, and the states of the stages that have checked it."""

    step: StepInput
    gate: GateState
    health: Health
    health_state: HealthState


class Sharing(NamedTuple):
    """Rider's share in the control, and the places where the rider may want to go."""

    authority: Authority
    """Before it is limited by recovery and docking."""
    authority_state: AuthorityState
    yielding: YieldingState | None
    """None outside shared mode."""
    destinations: DestinationBelief | None
    """None with a chosen destination."""
    destination_state: DestinationState | None


@dataclass(frozen=True, slots=True, kw_only=True)
class StageResults:
    """Results of the stages, in the order of the pipeline."""

    checked: CheckedInput
    world: WorldModel
    sharing: Sharing
    authority: Authority
    """Reduced where the chair takes over."""
    arrived: bool
    recovery: RecoveryUpdate
    motion: Motion
    decision: Decision


def tick_of(
    observation: Observation,
    request: Request,
    results: StageResults,
    durations: Mapping[str, float],
) -> Tick:
    """Combine the results of all stages into the tick of a step."""
    world, course, sharing = results.world, results.motion.course, results.sharing
    return Tick(
        observation=observation,
        request=request,
        decision=results.decision,
        memory=_memory(results),
        sensing=world.sensing,
        people=world.people,
        health=results.checked.health,
        groups=world.groups,
        predictions=world.predictions,
        spaces=world.spaces,
        path=course.route.path if course.route else None,
        reference=course.reference,
        authority=results.authority,
        recovery=results.recovery.action,
        shared=course.shared,
        plan=results.motion.plan,
        planning_error=course.failure.detail if course.failure else "",
        destinations=sharing.destinations,
        arrived=results.arrived,
        durations=MappingProxyType(durations),
    )


def _memory(results: StageResults) -> Memory:
    """State that each stage passes to its next call."""
    checked, world, sharing = results.checked, results.world, results.sharing
    motion, recovery = results.motion, results.recovery
    course = motion.course
    return Memory(
        gate=checked.gate,
        health=checked.health_state,
        perception=world.perception,
        predictor=world.predictor,
        obstacles=world.layer,
        floor=world.floor,
        openings=world.openings,
        route=course.route,
        planning_failure=course.failure,
        progress=course.progress,
        rear=recovery.rear,
        track=recovery.track,
        reversing=recovery.reversing,
        recovery=recovery.state,
        authority=sharing.authority_state,
        steering=motion.steering,
        yielding=with_disagreement(sharing.yielding, motion.own),
        destinations=sharing.destination_state,
        last_contact=world.last_contact,
    )


def stopped_by_input(
    observation: Observation,
    request: Request,
    reason: Reason,
    gate_state: GateState,
    last: Tick | None,
) -> Tick:
    """Return the stop for unusable input, or for STOP; the memory of all stages is kept."""
    memory = last.memory if last else Memory()
    if reason is Reason.RIDER_STOP and memory.health is not None:
        memory = replace(memory, health=acknowledged(memory.health))
    return Tick(
        observation=observation,
        request=request,
        decision=stop(reason),
        memory=replace(memory, gate=gate_state),
        people=last.people if last else People.empty(observation.time),
        path=last.path if last else None,
        arrived=last.arrived if last else False,
    )


def stopped_by_health(
    observation: Observation,
    request: Request,
    health: Health,
    gate_state: GateState,
    memory: Memory,
    last: Tick | None,
    *,
    people: People | None,
) -> Tick:
    """Return the stop for input that contradicts itself; other stages keep their memory.

    ``memory`` has the new state of the health monitor, ``health`` the reason. ``people``: if they
    were tracked all the same.
    """
    reason = health.stop or Reason.SENSORS_DISAGREE
    stopped = stopped_by_input(observation, request, reason, gate_state, last)
    after = replace(memory, gate=gate_state)
    known = stopped.people if people is None else people
    return replace(stopped, memory=after, health=health, people=known)


def with_health_reason(decision: Decision, health: Health) -> Decision:
    """Decision with the reason for driving slowly, where it has none of its own."""
    if health.slow is None or decision.reason not in {None, Reason.OVER_LIMITS}:
        return decision
    return replace(decision, reason=health.slow)
