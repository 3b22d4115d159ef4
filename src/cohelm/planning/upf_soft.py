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


class SoftPreferenceField:
    """A* under the weights w = w_base · (1 − α φ) of the field φ of ``upf``, scaled to 0…1.

    φ is the sum of the densities over the points, over its greatest value on the map. A cell in the
    valley costs less in proportion to what it cost before, so the slope of the inflation is still
    there, where ``upf`` takes the maximum and may cover it.
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
    """Weights w · (1 − α φ / max φ) of a field φ (rows, cols) that is nowhere negative."""
    packed, lightest = _discounted(weights.packed, field, discount / float(field.max()))
    packed.flags.writeable = False
    return Weights(
        packed=packed, lightest=min(lightest, weights.heaviest), heaviest=weights.heaviest
    )


@njit(cache=True)
def _discounted(packed: Floats32, field: Floats32, share: float) -> tuple[Floats32, float]:
    """(packed weights, the least of them)."""
    out, lightest = packed.copy(), np.inf
    for r in range(field.shape[0]):
        for c in range(field.shape[1]):
            out[r + 1, c + 1] *= 1.0 - share * field[r, c]
            lightest = min(lightest, out[r + 1, c + 1])
    return out, lightest
