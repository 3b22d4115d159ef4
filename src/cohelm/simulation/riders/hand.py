"""What all hands share: a push of the stick, and the hand of somebody else to spoil."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import RiderCommand
from cohelm.plugins import Spec, build
from cohelm.simulation.api import Rider, RiderAct, RiderView

Underlying = Spec
"""The rider whose hand is spoilt."""

IDEAL = {"use": "ideal"}


def underlying(spec: Mapping[str, Any]) -> Rider:
    """The rider that ``spec`` names.

    Raises:
        PluginError, ConfigError: see :func:`cohelm.plugins.build`.
    """
    rider: Rider = build("riders", spec, key="of")
    return rider


def steered(view: RiderView, deflection: Sequence[float] | Floats, memory: Any = None) -> RiderAct:
    """A push of the stick (forward, left) now, as far as the stick goes."""
    return RiderAct(
        command=RiderCommand(
            heartbeat=view.time,
            deflection=np.clip(np.asarray(deflection, dtype=np.float64), -1.0, 1.0),
        ),
        memory=memory,
    )


def turned(deflection: Floats, angle: float) -> Floats:
    """A deflection (2,) pointed ``angle`` (rad) further to the left."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * deflection[0] - s * deflection[1], s * deflection[0] + c * deflection[1]])


def drawn(bounds: tuple[float, float], rng: np.random.Generator) -> float:
    """A number between two bounds, each as likely as any other."""
    return float(rng.uniform(*bounds))
