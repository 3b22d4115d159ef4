"""What a social model is."""

from __future__ import annotations

from typing import Protocol

from cohelm.arrays import Floats
from cohelm.messages import Groups, People, Predictions, RiderProfile, SocialSpaces


class SocialModel(Protocol):
    """An entry point of ``cohelm.social_models``: which shape for this person, this group."""

    def spaces(
        self,
        people: People,
        groups: Groups,
        predictions: Predictions,
        twist: Floats,
        profile: RiderProfile,
    ) -> SocialSpaces:
        """The space of each person over the horizon, and of a robot with this twist (3,)."""
        ...
