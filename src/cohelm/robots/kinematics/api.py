"""Interface of a motion model."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from cohelm.arrays import Annotated, Floats, Shape


class InputBounds(NamedTuple):
    """Limits of the inputs, (m,) each."""

    low: Floats
    """Lowest input."""
    high: Floats
    """Highest input."""
    rise: Floats
    """Largest increase per second."""
    fall: Floats
    """Largest decrease per second."""


class Kinematics(Protocol):
    """A motion model x⁺ = f(x, u) with m inputs, discretised with step dt.

    Its first ``translating`` inputs are the velocity over the floor in the robot frame, so that
    their Euclidean norm is the robot's speed. The others turn it.
    """

    inputs: int
    """m."""
    translating: int
    """Number of leading inputs that move it over the floor: 1, along x only, or 2."""
    turned: float
    """Share of a step's turn that happens before its translation, 0 to 1."""
    facets: Annotated[Floats, Shape("f m")]
    """F of the linear inequalities F u ≤ speed that bound the norm of the translating inputs;
    empty where the bounds of each input suffice."""

    def __hash__(self) -> int:
        """Identity is enough: models are used as cache keys."""
        ...

    def twist(self, u: Floats) -> Floats:
        """The twist (..., 3) of inputs (..., m)."""
        ...

    def input(self, twist: Floats) -> Floats:
        """The inputs (..., m) nearest to a twist (..., 3)."""
        ...

    def bounds(self, limits: Floats) -> InputBounds:
        """Input bounds from a robot's limits.

        Args:
            limits: (v_max, v_reverse, ω_max, a_max, a_brake, α_max), all ≥ 0.
        """
        ...

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """Poses (N+1, 3) from ``pose`` under inputs (N, m); headings are not wrapped."""
        ...

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """∂poses/∂inputs along a rollout, (N+1, 3, N·m); column m·j + i is input i at step j."""
        ...
