"""Interface of social models."""

from __future__ import annotations

from typing import Protocol

from cohelm.arrays import Floats
from cohelm.messages import Groups, People, Predictions, RiderProfile, SocialSpaces


class SocialModel(Protocol):
    """Entry point of ``cohelm.social_models``: shapes of the spaces of people and groups."""

    def spaces(
        self,
        people: People,
        groups: Groups,
        predictions: Predictions,
        twist: Floats,
        profile: RiderProfile,
    ) -> SocialSpaces:
        """Compute the space of each person over the horizon, and of a robot with a twist (3,)."""
        ...
