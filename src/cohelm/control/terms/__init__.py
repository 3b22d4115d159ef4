"""Terms and barriers of the local planner's objective, one module each.

A module has the parameters (a ``Model``), a ``table`` made of them once a tick, and compiled
functions: ``cost`` of a stage (or ``final_cost`` of the last state) and ``model``, its gradient and
curvature. ``stage`` and ``encounter`` hold what they share, ``barrier`` the control barriers,
``extra`` terms of one's own. ``cohelm.control.objective`` sums all of them.
"""

from cohelm.control.terms.barrier import Barrier, WallBarrier
from cohelm.control.terms.extra import ExtraTerm, residual
from cohelm.control.terms.final_heading import FinalHeading
from cohelm.control.terms.group_space import GroupSpace
from cohelm.control.terms.input_change import InputChange
from cohelm.control.terms.input_effort import InputDeviation, InputEffort
from cohelm.control.terms.path_distance import PathDistance
from cohelm.control.terms.person_clearance import PersonClearance
from cohelm.control.terms.personal_space import PersonalSpaceCost
from cohelm.control.terms.progress import Progress
from cohelm.control.terms.track_reference import TrackReference
from cohelm.control.terms.wall_clearance import WallClearance

__all__ = [
    "Barrier",
    "ExtraTerm",
    "FinalHeading",
    "GroupSpace",
    "InputChange",
    "InputDeviation",
    "InputEffort",
    "PathDistance",
    "PersonClearance",
    "PersonalSpaceCost",
    "Progress",
    "TrackReference",
    "WallBarrier",
    "WallClearance",
    "residual",
]
