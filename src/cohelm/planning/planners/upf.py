"""Planners with the user preference field: as a layer (the paper's), and as a discount."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats32
from cohelm.kernels import CACHED
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.costmap.costmap import combine
from cohelm.planning.costmap.layers.preference import (
    Preference,
    Source,
    preference_costs,
    preference_field,
    sources_of,
)
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.planners.route import (
    GridPlannerParameters,
    find_route,
    route_without_wishes,
    to_path,
)
from cohelm.planning.problem import PreparedProblem, prepare, weigh

STEPS = 64
"""Number of steps of φ from 0 to 1; the error of a metre's weight is at most α / 128.

If every cell's weight differs slightly from its neighbour's, equal paths are almost never exactly
equal, and on some maps cells are expanded a hundred times each for tiny improvements. With steps,
most weights are locally uniform."""

_FINER = 8.0
"""Factor by which the buckets of the open list are finer than usual, for the same reason."""


class UserPreferenceField:
    """Xu et al., eqs. (1) and (2), Algorithm 1, with the corrections that ``Preference`` names.

    d_r of eq. (1) is the distance from ``RouteProblem.wish_origin`` to the point. All points
    attract at once: the field has no order.
    """

    class Parameters(GridPlannerParameters):
        """Parameters of every grid planner, and of the field."""

        preference: Preference = Preference()

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        p = self.parameters
        return _plan_with_field(problem, p, p.preference, self._reweighed, method="upf")

    def _reweighed(self, prepared: PreparedProblem, sources: tuple[Source, ...]) -> Weights:
        """Weights with the field as a layer of the costmap, by maximum."""
        layer = preference_costs(prepared.costmap.grid, sources, self.parameters.preference)
        return weigh(combine(prepared.costmap, layer), prepared.start, self.parameters)


class SoftPreferenceField:
    """A* under the weights w = w_base · (1 − α φ) of the field φ of ``upf``, scaled to 0…1.

    φ is the sum of the densities over the points, divided by its maximum on the map, in steps of
    1 / ``STEPS``. A cell near a point costs less in proportion to its cost before, so the slope of
    the inflation remains, where ``upf`` takes the maximum and may cover it.
    """

    class Parameters(GridPlannerParameters):
        """Parameters of every grid planner, and of the field; assumed."""

        preference: Preference = Preference()
        """Only ``density`` and ``sigma_min`` are used."""
        discount: float = Field(0.5, gt=0.0, lt=1.0)
        """α: at the maximum of the field, a metre costs 1 − α of its cost without the field."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        p = self.parameters
        return _plan_with_field(problem, p, p.preference, self._reweighed, method="upf_soft")

    def _reweighed(self, prepared: PreparedProblem, sources: tuple[Source, ...]) -> Weights:
        """Weights with the field as a discount."""
        field = preference_field(prepared.costmap.grid, sources, self.parameters.preference)
        return discounted(prepared.weights, field, self.parameters.discount)


def discounted(weights: Weights, field: Floats32, discount: float) -> Weights:
    """Weights w · (1 − α φ / max φ) of a field φ (rows, cols) ≥ 0, in steps."""
    packed, lightest = _discounted(weights.packed, field, STEPS / float(field.max()), discount)
    packed.flags.writeable = False
    lightest = min(lightest, weights.heaviest) / _FINER
    return Weights(packed=packed, lightest=lightest, heaviest=weights.heaviest)


def _plan_with_field(
    problem: RouteProblem,
    parameters: GridPlannerParameters,
    preference: Preference,
    reweigh: Callable[[PreparedProblem, tuple[Source, ...]], Weights],
    *,
    method: str,
) -> Path:
    """Plan the cheapest path under weights changed by a preference field.

    ``reweigh`` gives the weights from the prepared problem and the sources of the field.
    """
    prepared = prepare(problem, parameters)
    plain = find_route(prepared, parameters)
    without = route_without_wishes(prepared, parameters, plain)
    origin = problem.start if problem.wish_origin is None else problem.wish_origin
    sources = sources_of(problem.wishes, origin, preference)
    if not sources:
        return to_path(prepared, plain, without, method=method)
    weights = reweigh(prepared, sources)
    route = find_route(prepared, parameters, weights)
    return to_path(prepared, route, without, method=method)


@njit(**CACHED)
def _discounted(
    packed: Floats32, field: Floats32, scale: float, discount: float
) -> tuple[Floats32, float]:
    """(packed weights, the lowest of them)."""
    out, lightest = packed.copy(), np.inf
    for r in range(field.shape[0]):
        for c in range(field.shape[1]):
            out[r + 1, c + 1] *= 1.0 - discount / STEPS * np.rint(scale * field[r, c])
            lightest = min(lightest, out[r + 1, c + 1])
    return out, lightest
