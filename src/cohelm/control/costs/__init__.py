"""The summands of the cost, one file each."""

from cohelm.control.costs.comfort import Comfort
from cohelm.control.costs.gauss_newton import gauss_newton
from cohelm.control.costs.input_effort import InputEffort
from cohelm.control.costs.progress import Progress
from cohelm.control.costs.smooth_input import SmoothInput
from cohelm.control.costs.track_reference import TrackReference

__all__ = [
    "Comfort",
    "InputEffort",
    "Progress",
    "SmoothInput",
    "TrackReference",
    "gauss_newton",
]
