"""Values of steering help: parameters, memory of a stick, and the motion that it asks for."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.messages import Reference
from cohelm.sharing.hand import FREE_STICK, HandState
from cohelm.sharing.passage_wait import PassageWait


class SteeringParameters(Model):
    """Meaning of a stick, and limits of how far the chair may differ from it; assumed."""

    smoothing: float = Field(0.25, ge=0.0, le=2.0)
    """Time constant of the low-pass on the stick, s."""
    turn_time: float = Field(0.8, ge=0.0, le=5.0)
    """Time for which a turn is meant, s."""
    turn_fade: float = Field(0.6, gt=0.0, le=5.0)
    """Time in which it then fades, s."""
    straight: float = Field(0.12, ge=0.0, le=1.0)
    """Lateral deflection up to which the direction is kept, share of full."""
    keep_time: float = Field(3.0, gt=0.0, le=60.0)
    """Time constant with which a kept direction gives way to that of the chair, s."""
    lean: float = Field(0.04, ge=0.0, le=1.0)
    """Angle of the stick from which it closes the other side, rad; its unsteadiness is added."""
    late_time: float = Field(0.8, gt=0.0, le=10.0)
    """A steady or leaning stick is overruled only as much as keeps this time clear, s; twice the
    time with coarse input."""
    hand: Literal["auto", "stick", "eight_directions", "one_switch"] = "auto"
    """Kind of the rider's input, see ``sharing.hand``; ``auto``: recognised by its messages."""
    attraction: float = Field(1.0, ge=0.0, le=1.0)
    """Share of the width of the rider's direction in which doors, passages and free space attract;
    0: off."""
    reach: float = Field(4.0, gt=0.0, le=10.0)
    """Distance ahead that should be free, m."""
    max_deviation: float = Field(1.05, gt=0.0, le=3.2)
    """Largest angle between the motion of the chair and where the stick leads, rad."""
    clear_time: float = Field(3.0, gt=0.0, le=10.0)
    """Time for which the stick's own motion must stay clear to be taken unchanged, s. For obstacles
    that stand it holds with coarse or unsteady input …"""
    steady_clear_time: float = Field(0.8, gt=0.0, le=10.0)
    """… and this time with a steady stick, which is followed closer to obstacles, s; clear means
    farther …"""
    wall_gap: float = Field(0.05, ge=0.0, le=0.5)
    """… than this to walls, m …"""
    people_gap: float = Field(0.15, ge=0.0, le=1.0)
    """… and this to people, m."""
    stuck_time: float = Field(1.0, gt=0.0, le=30.0)
    """Time of pushing without motion after which the chair squeezes through, s …"""
    squeeze_time: float = Field(4.0, ge=0.0, le=60.0)
    """… for this time, slowly and closer to people and walls than otherwise, s."""


@value
class SteeringState:
    """Memory of the rider's intent."""

    time: float
    """s."""
    stick: Annotated[Floats, Shape("2")]
    """Deflection after the low-pass."""
    hand: HandState = FREE_STICK
    """With the width of the rider's direction."""
    heading: float = math.nan
    """Direction in the map that a straight stick keeps, rad; NaN: none."""
    aim: float = math.nan
    """Heading within the interval about it to which the chair is led, rad; NaN: none."""
    turned_since: float = math.inf
    """Time since which the stick turns the chair on the spot, s."""
    pushed_since: float = math.inf
    """Time since which a push has moved nothing, s."""
    squeezes_until: float = -math.inf
    """s."""
    wait: PassageWait | None = None
    """For a person who comes through the narrow passage ahead."""


@value
class RiderIntent:
    """Motion that the rider's stick asks for."""

    inputs: Annotated[Floats, Shape("N m")]
    """Inputs of the rider's own motion."""
    reference: Reference
    """Poses and speeds, N + 1 each, of the motion that is led to what lies ahead."""
    speed: float
    """Speed of the stick, m/s."""
    return_rate: float
    """Turn rate back to the direction of the push for a chair that was led aside, rad/s."""
    turn_share: float
    """Share of the turn rate of a turn on the spot: less at first with a single switch."""
    lean: int
    """Side to which the stick leans: 1 left, −1 right, 0 neither."""
    forward: bool
    """The rider pushes forward; otherwise the chair turns on the spot, backs up or stands."""
    late_time: float
    """The stick is overruled only as much as keeps this time clear, s; 0: no such limit."""
    clear_time: float
    """The rider's own motion is taken while it is clear of standing obstacles for this time, s."""
    wall_gap: float
    """The rider's own motion is taken while it keeps this gap to walls, m."""
    squeezes: bool
    """A push has moved nothing for a while."""
    waits: bool = False
    """A person comes through the narrow passage ahead, and needs the space before it."""
