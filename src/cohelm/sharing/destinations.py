"""Destination inference: probabilities of destinations from the motion and the stick of a rider.

A rider who wants to go to g drives almost the shortest way to it. Along the driven distance d the
cost-to-go V_g should fall by as much, and

    detour_g = d − (V_g(then) − V_g(now))

is between 0 (straight there) and about 2 d (straight away). With a Boltzmann-rational rider

    P(g) ∝ prior(g) · exp(−β · Σ detour_g),

(Ziebart et al., Planning-based prediction for pedestrians, 2009; Dragan and Srinivasa, A
policy-blending formalism for shared control, 2013). The sum forgets along the driven distance:
riders change their minds. A stick that is deflected adds the detour of the next metre in its
direction. *Somewhere else* is a destination whose detour is always the same share of the driven
distance.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.config import Model

_LONGEST_GAP = 0.5
"""Time between two updates beyond which the stick is not smoothed over it, s."""
_JUMP = 1.0
"""Distance between two updates that no chair drives: the position was corrected, m."""
_NO_WAY = 1e5
"""Cost-to-go from which there is no way, m."""


class InferenceParameters(Model):
    """Parameters of the inference; tuned by ``cohelm bench destinations`` on other floors."""

    beta: float = Field(1.5, gt=0.0, le=20.0)
    """Inverse temperature β: weight of a metre of detour, 1/m."""
    forgetting: float = Field(12.0, gt=0.0, le=1000.0)
    """Driven distance in which evidence falls to 1/e, m."""
    step: float = Field(0.1, gt=0.0, le=1.0)
    """Driven distance between two updates, m; less is noise of the localiser."""
    stick_distance: float = Field(1.0, ge=0.0, le=10.0)
    """Distance ahead that a deflected stick speaks for, m."""
    stick_turn_time: float = Field(0.8, ge=0.0, le=5.0)
    """Time for which a turn of the stick is meant, s; as in steering help."""
    stick_smoothing: float = Field(1.0, ge=0.0, le=10.0)
    """Time constant of the low-pass on the detour that the stick asks for, s."""
    elsewhere_prior: float = Field(0.15, gt=0.0, lt=1.0)
    """Prior probability of a destination without a name."""
    elsewhere_detour: float = Field(0.25, ge=0.0, le=2.0)
    """Detour of such a destination, share of the driven distance."""
    habits: dict[str, int] = Field(default_factory=dict)
    """Number of earlier rides to a place, by its name; empty: all places are equally likely."""


@value
class InferenceState:
    """Memory of the inference; sums are over the driven distance, with forgetting."""

    time: float
    """s."""
    anchor: Annotated[Floats, Shape("2")]
    """Position at the last update, m."""
    cost: Annotated[Floats, Shape("n")]
    """Cost-to-go there, m."""
    driven: float
    """Driven distance, m."""
    progress: Annotated[Floats, Shape("n")]
    """Distance by which the chair has come closer to each place, m."""
    stick: float
    """Length of the line that the stick speaks for, m, after the low-pass."""
    stick_progress: Annotated[Floats, Shape("n")]
    """Distance by which this line comes closer to each place, m, after the low-pass."""


@value
class StickLine:
    """Straight line from the chair to where the stick leads next."""

    length: float
    """m."""
    cost: Annotated[Floats, Shape("n")]
    """Cost-to-go at its end, m."""


def update_inference(
    time: float,
    position: Floats,
    cost: Floats,
    line: StickLine | None,
    memory: InferenceState | None,
    parameters: InferenceParameters,
) -> InferenceState:
    """Add the motion since the last update, and the stick, to the evidence.

    A chair that stands with a released stick leaves the memory as it is.

    Args:
        time: s.
        position: (2,), map frame, m.
        cost: cost-to-go (n,) there, m.
        line: where the stick leads; None: released, or it leads nowhere.
        memory: result of the last call; None at first.
        parameters: of the inference.
    """
    if memory is None:
        zeros = np.zeros(len(cost))
        memory = InferenceState(
            time=time,
            anchor=position,
            cost=cost,
            driven=0.0,
            progress=zeros,
            stick=0.0,
            stick_progress=zeros,
        )
    moved = _moved(position, cost, memory, parameters)
    return moved if line is None else _steered(time, cost, line, moved, parameters)


def belief(
    state: InferenceState, cost: Floats, prior: Floats, parameters: InferenceParameters
) -> Floats:
    """Probabilities (n + 1,) of the places and, last, of somewhere else; they sum to 1.

    Args:
        state: the evidence.
        cost: cost-to-go (n,) now, m; a place without a way has probability 0.
        prior: (n + 1,), see :func:`prior_of`.
        parameters: of the inference.
    """
    driven = state.driven + state.stick
    detour = np.append(
        driven - state.progress - state.stick_progress, parameters.elsewhere_detour * driven
    )
    score = np.log(prior) - parameters.beta * detour
    score[:-1][cost >= _NO_WAY] = -np.inf
    weight = np.exp(score - score.max())
    out: Floats = weight / weight.sum()
    return out


def prior_of(names: tuple[str, ...], parameters: InferenceParameters) -> Floats:
    """Prior probabilities (n + 1,) of places and, last, of somewhere else.

    Each place counts one ride more than it had, so that none is impossible.
    """
    counts = np.array([1.0 + max(parameters.habits.get(name, 0), 0) for name in names])
    if not len(names):
        return np.ones(1)
    named = (1.0 - parameters.elsewhere_prior) * counts / counts.sum()
    return np.append(named, parameters.elsewhere_prior)


def _moved(
    position: Floats, cost: Floats, memory: InferenceState, p: InferenceParameters
) -> InferenceState:
    distance = float(np.hypot(*(position - memory.anchor)))
    if distance < p.step:
        return memory
    if distance > _JUMP:
        return replace(memory, anchor=position, cost=cost)
    kept = math.exp(-distance / p.forgetting)
    return replace(
        memory,
        anchor=position,
        cost=cost,
        driven=kept * memory.driven + distance,
        progress=kept * memory.progress + _closer(memory.cost, cost),
    )


def _steered(
    time: float, cost: Floats, line: StickLine, memory: InferenceState, p: InferenceParameters
) -> InferenceState:
    elapsed = min(max(time - memory.time, 0.0), _LONGEST_GAP)
    share = 1.0 if p.stick_smoothing <= 0.0 else 1.0 - math.exp(-elapsed / p.stick_smoothing)
    closer = _closer(cost, line.cost)
    return replace(
        memory,
        time=time,
        stick=memory.stick + share * (line.length - memory.stick),
        stick_progress=memory.stick_progress + share * (closer - memory.stick_progress),
    )


def _closer(before: Floats, after: Floats) -> Floats:
    """Fall of the cost-to-go (n,), m; 0 where there is no way."""
    return np.where((before < _NO_WAY) & (after < _NO_WAY), before - after, 0.0)
