"""Ways round: candidates that a gradient method would not find by itself."""

from cohelm.control.candidates.arcs import Arcs, Outlook
from cohelm.control.candidates.ways import Ways

__all__ = ["Arcs", "Outlook", "Ways"]
