"""Parts of all messages: bounded numbers, bounded lengths, and words from short lists."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from cohelm.config import FrozenModel

VERSION = 4
"""Version of the messages; grows with every change that an older page would not understand."""
MAX_MESSAGE_SIZE = 16_384
"""Maximum size of a message from a page, bytes."""

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Point = Annotated[tuple[Finite, Finite], Field(description="(x, y), m")]
Line = Annotated[tuple[Point, ...], Field(min_length=1, max_length=300)]
Deflection = Annotated[float, Field(allow_inf_nan=False, ge=-1.0, le=1.0)]
Name = Annotated[str, Field(min_length=1, max_length=80)]
Number = Annotated[int, Field(ge=0, le=2**53 - 1)]
Device = Literal["none", "joystick", "gamepad", "keys", "switch"]
Pace = Literal["slow", "normal", "brisk"]
WishKind = Literal["attract", "avoid", "stroke"]


class WireMessage(FrozenModel):
    """Base of all messages: frozen, without undeclared fields."""

    model_config = ConfigDict(use_attribute_docstrings=True)  # they are the page's comments, too


class RouteFigures(WireMessage):
    """Figures of a route that the rider's choices are learned from."""

    length: Finite
    """m."""
    clearance: Finite
    """Mean, m."""
    encounters: Finite
    """People near the route."""
    turns: Finite
    doors: Finite
    """Narrow passages."""
