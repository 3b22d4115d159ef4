"""What messages of both ways are made of: bounded numbers and lengths, words from short lists."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cohelm.config import Model

VERSION = 1
"""Of the messages; grows with every change that a page of before would not understand."""
LARGEST = 16_384
"""A message from a page is no longer than this, bytes."""

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Point = Annotated[tuple[Finite, Finite], Field(description="(x, y), m")]
Line = Annotated[tuple[Point, ...], Field(min_length=1, max_length=300)]
Deflection = Annotated[float, Field(allow_inf_nan=False, ge=-1.0, le=1.0)]
Name = Annotated[str, Field(min_length=1, max_length=80)]
Number = Annotated[int, Field(ge=0, le=2**53 - 1)]
Device = Literal["none", "joystick", "gamepad", "keys", "switch"]
Pace = Literal["slow", "normal", "brisk"]
WishKind = Literal["attract", "avoid", "stroke"]


class Message(Model):
    """One message; frozen, and nothing in it that is not declared."""
