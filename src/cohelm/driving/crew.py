"""Whoever works for the chair aside, so that it waits for none of them."""

from __future__ import annotations

from dataclasses import dataclass

from cohelm.driving.outings import Outings
from cohelm.driving.playing import Playing
from cohelm.driving.pricing import Pricing
from cohelm.driving.thinking import Thinking


@dataclass(frozen=True, slots=True, kw_only=True)
class Crew:
    """All of them."""

    thinking: Thinking
    """The navigator."""
    pricing: Pricing
    """Of wishes."""
    playing: Playing
    """Worlds."""
    outings: Outings
    """The rides."""
