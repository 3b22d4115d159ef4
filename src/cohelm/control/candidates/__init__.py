"""Ways round: candidates that a gradient method would not find by itself."""

from cohelm.control.candidates.arcs import best_arcs

__all__ = ["best_arcs"]
