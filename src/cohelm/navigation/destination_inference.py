"""Destinations of a rider who has chosen none: belief, and offers that take one press.

Nothing here changes the request: an offer becomes the destination only when the rider says so.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, value
from cohelm.config import Model
from cohelm.maps import CostmapFilter, OccupancyGrid, Places
from cohelm.messages import (
    DestinationBelief,
    DestinationOffer,
    OfferReason,
)
from cohelm.planning import CostToGo, cost_to_go
from cohelm.sharing import (
    EMPTY,
    InferenceParameters,
    InferenceState,
    OfferParameters,
    OfferState,
    StickLine,
    belief,
    prior_of,
    update_inference,
    update_offers,
)

_CLEARANCE = 0.05
"""Added to the inscribed radius of the chair, m: that of a rider's profile by default."""
_CLOSER = 1.0
"""Progress from which the rider is told of it, m."""
_TOWARDS = 0.5
"""Share of the stick's line that comes closer, from which the rider steers towards a place."""


class DestinationParameters(Model):
    """Parameters of inference and offers."""

    infer: bool = True
    """Infer destinations on maps with named places; False: offer none."""
    inference: InferenceParameters = Field(default_factory=InferenceParameters)
    offers: OfferParameters = Field(default_factory=OfferParameters)


@value
class DestinationState:
    """Memory of the inference and of the offers."""

    inference: InferenceState
    offers: OfferState


class DestinationInference:
    """Inference on one map; it holds the fields of the map, and nothing that changes.

    Args:
        fields: cost-to-go of all places.
        names: of the places.
        parameters: of inference and offers.
    """

    def __init__(
        self, fields: CostToGo, names: tuple[str, ...], parameters: DestinationParameters
    ) -> None:
        self.fields, self.names, self.parameters = fields, names, parameters
        self.prior = prior_of(names, parameters.inference)

    def update(
        self,
        time: float,
        pose: Floats,
        deflection: Floats,
        max_turn_rate: float,
        memory: DestinationState | None,
    ) -> tuple[DestinationBelief, DestinationState]:
        """Update belief and offers.

        Args:
            time: s.
            pose: (3,), X_MR.
            deflection: (forward, left) of the stick, 0 where it counts as centred.
            max_turn_rate: of a full deflection, rad/s.
            memory: result of the last call; None at first.
        """
        p = self.parameters.inference
        cost = self.fields.at(pose[:2])
        line = self._stick_line(pose, deflection, max_turn_rate)
        before = memory.inference if memory else None
        state = update_inference(time, pose[:2], cost, line, before, p)
        probability = belief(state, cost, self.prior, p)
        shown = memory.offers if memory else None
        still = memory is not None and state is before
        offers = (
            memory.offers
            if memory is not None and still
            else update_offers(time, probability, cost, shown, self.parameters.offers)
        )
        result = DestinationBelief(
            places=probability[:-1],
            elsewhere=float(probability[-1]),
            offers=self._offers(offers, state, probability),
        )
        if memory is not None and still and offers is memory.offers:
            return result, memory
        return result, DestinationState(inference=state, offers=offers)

    def _stick_line(
        self, pose: Floats, deflection: Floats, max_turn_rate: float
    ) -> StickLine | None:
        """Line to where the stick leads; None without one, and where the chair backs up."""
        p, (forward, left) = self.parameters.inference, deflection.tolist()
        if (forward == 0.0 and left == 0.0) or forward < 0.0:
            return None
        direction = float(pose[2]) + left * max_turn_rate * p.stick_turn_time
        end = self.fields.reached(pose[:2], direction, p.stick_distance)
        length = math.hypot(*(end - pose[:2]).tolist())
        return StickLine(length=length, cost=self.fields.at(end)) if length > 0.0 else None

    def _offers(
        self, shown: OfferState, state: InferenceState, probability: Floats
    ) -> tuple[DestinationOffer, ...]:
        return tuple(
            DestinationOffer(
                name=self.names[k],
                slot=slot,
                belief=float(probability[k]),
                highlighted=k == shown.highlighted,
                reason=self._reason(k, state),
                progress=float(state.progress[k]),
            )
            for slot, k in enumerate(shown.slots)
            if k != EMPTY
        )

    def _reason(self, place: int, state: InferenceState) -> OfferReason:
        closer = state.progress[place] >= _CLOSER
        towards = state.stick > 0.0 and state.stick_progress[place] >= _TOWARDS * state.stick
        if closer:
            return OfferReason.CLOSER_AND_STEERING if towards else OfferReason.CLOSER
        if towards:
            return OfferReason.STEERING
        often = self.prior[place] > 1.5 * (1.0 - self.prior[-1]) / len(self.names)
        return OfferReason.HABIT if often else OfferReason.STILL_POSSIBLE


def destination_inference(
    grid: OccupancyGrid,
    filters: tuple[CostmapFilter, ...],
    places: Places,
    inscribed_radius: float,
    parameters: DestinationParameters,
) -> DestinationInference | None:
    """Compute the fields of a map; None without places, or where nothing is to be inferred.

    Args:
        grid, filters: map and masks.
        places: destinations.
        inscribed_radius: of the chair, m.
        parameters: of inference and offers.
    """
    if not parameters.infer or not len(places):
        return None
    points = np.array([place.point for place in places])
    fields = cost_to_go(grid, inscribed_radius + _CLEARANCE, points, filters)
    return DestinationInference(fields, places.names, parameters)
