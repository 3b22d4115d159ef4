"""The user preference field as a discount on the way, so that costs near walls keep their slope."""

from __future__ import annotations

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats32
from cohelm.messages import Path
from cohelm.planning.api import RouteProblem
from cohelm.planning.by_field import path_by_field
from cohelm.planning.ground import Ground
from cohelm.planning.layers.preference import Preference, Source, preference_field
from cohelm.planning.route import RouteParameters
from cohelm.planning.search import Weights

STEPS = 64
"""In which φ goes from 0 to 1; a metre's weight is off by no more than α / 128.

Where every cell's weight is a little other than its neighbour's, equal ways are hardly ever quite
equal: cells become cheaper by next to nothing again and again, a hundred times each on some maps.
Steps make most of the ground even."""

_FINER = 8.0
"""By how much the open list sorts finer than the lightest cell asks for, for the same reason."""


class SoftPreferenceField:
    """A* under the weights w = w_base · (1 − α φ) of the field φ of ``upf``, scaled to 0…1.

    φ is the sum of the densities over the points, over its greatest value on the map, in steps of
    1 / ``STEPS``. A cell in the valley costs less in proportion to what it cost before, so the
    slope of the inflation is still there, where ``upf`` takes the maximum and may cover it.
    """

    class Parameters(RouteParameters):
        """Those of every grid planner, and the field's; the figures are assumed."""

        preference: Preference = Preference()
        """Of which ``density`` and ``sigma_min`` count."""
        discount: float = Field(0.5, gt=0.0, lt=1.0)
        """α: at the peak a metre counts 1 − α of what it did."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def plan(self, problem: RouteProblem) -> Path:
        """See :meth:`cohelm.planning.GlobalPlanner.plan`. Without wishes it is A*."""
        parameters = self.parameters
        return path_by_field(
            problem, parameters, parameters.preference, self._reweighed, method="upf_soft"
        )

    def _reweighed(self, ground: Ground, sources: tuple[Source, ...]) -> Weights:
        """With the field as a discount."""
        field = preference_field(ground.costmap.grid, sources, self.parameters.preference)
        return discounted(ground.weights, field, self.parameters.discount)


def discounted(weights: Weights, field: Floats32, discount: float) -> Weights:
    """Weights w · (1 − α φ / max φ) of a field φ (rows, cols) ≥ 0, in steps."""
    packed, lightest = _discounted(weights.packed, field, STEPS / float(field.max()), discount)
    packed.flags.writeable = False
    lightest = min(lightest, weights.heaviest) / _FINER
    return Weights(packed=packed, lightest=lightest, heaviest=weights.heaviest)


@njit(cache=True)
def _discounted(
    packed: Floats32, field: Floats32, scale: float, discount: float
) -> tuple[Floats32, float]:
    """(packed weights, the least of them)."""
    out, lightest = packed.copy(), np.inf
    for r in range(field.shape[0]):
        for c in range(field.shape[1]):
            out[r + 1, c + 1] *= 1.0 - discount / STEPS * np.rint(scale * field[r, c])
            lightest = min(lightest, out[r + 1, c + 1])
    return out, lightest
