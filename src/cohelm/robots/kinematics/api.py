"""What a motion model is."""

from __future__ import annotations

from typing import Protocol

from cohelm.arrays import Annotated, Floats, Shape


class Kinematics(Protocol):
    """A motion model x⁺ = f(x, u) with m inputs, discretised with step dt.

    Its first ``translating`` inputs are the velocity over the floor in the robot frame, so that
    their Euclidean norm is the robot's speed; the others turn it.
    """

    inputs: int
    """m."""
    translating: int
    """How many inputs, the first ones, move it over the floor: 1, along x only, or 2."""
    turned: float
    """Share of a step's turn that is made before the step moves over the floor, 0 to 1."""
    facets: Annotated[Floats, Shape("f m")]
    """F of the linear inequalities F u ≤ speed that keep the norm of the translating inputs below
    a speed; none where the bounds on each input do that already."""

    def __hash__(self) -> int:
        """A model is a key of what follows from it; its own identity will do."""
        ...

    def twist(self, u: Floats) -> Floats:
        """The twist (..., 3) of inputs (..., m)."""
        ...

    def input(self, twist: Floats) -> Floats:
        """The inputs (..., m) nearest to a twist (..., 3)."""
        ...

    def bounds(self, limits: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Input bounds from a robot's limits.

        Args:
            limits: (v_max, v_reverse, ω_max, a_max, a_brake, α_max), all ≥ 0.

        Returns:
            (lower, upper, greatest rise a second, greatest fall a second), each (m,).
        """
        ...

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """Poses (N+1, 3) from ``pose`` under inputs (N, m); headings are not wrapped."""
        ...

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """∂poses/∂inputs along a rollout, (N+1, 3, N·m); column m·j + i is input i at step j."""
        ...
