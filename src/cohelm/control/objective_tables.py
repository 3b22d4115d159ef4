"""Tables of the objective: the records of all terms for one scene, and a workspace."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.scene import Scene
from cohelm.control.terms import (
    barrier,
    extra,
    final_heading,
    group_space,
    input_change,
    input_effort,
    path_distance,
    person_clearance,
    personal_space,
    progress,
    track_reference,
    wall_clearance,
)

# BODIES and SOCIAL are neighbours: ``objective`` adds the kind of a barrier to the first.
(PROGRESS, PATH, HEADING, EFFORT, CHANGE, TRACK, PERSON, SPACE, GROUP, WALL,
 BODIES, SOCIAL, WALLS) = range(13)  # fmt: skip
TERMS = (
    progress.NAME, path_distance.NAME, final_heading.NAME, input_effort.NAME, input_change.NAME,
    track_reference.NAME, person_clearance.NAME, personal_space.NAME, group_space.NAME,
    wall_clearance.NAME, "bodies", "social_space", "walls",
)  # fmt: skip
"""Names of all summands; the last three are the prices of barriers. Terms of one's own follow."""
FIRST_EXTRA = len(TERMS)


class Objective(NamedTuple):
    """Tables of all terms and barriers for one scene."""

    progress: progress.ProgressTable
    path: path_distance.PathDistanceTable
    heading: final_heading.FinalHeadingTable
    effort: input_effort.InputEffortTable
    change: input_change.InputChangeTable
    track: track_reference.TrackTable
    person: person_clearance.PersonClearanceTable
    space: personal_space.PersonalSpaceTable
    group: group_space.GroupSpaceTable
    wall: wall_clearance.WallClearanceTable
    bodies: barrier.BarrierTable
    social: barrier.BarrierTable
    walls: barrier.BarrierTable
    extra: extra.ExtraTable
    start: Floats
    """(P, 2) h of bodies and of social spaces now, saturated."""
    widest: float
    """A person farther away than this has no cost, m."""


class Workspace(NamedTuple):
    """Arrays of one evaluation; what they hold is only valid during it."""

    by_term: Floats
    """(T,) cost of each summand, s."""
    due: Floats
    """(P,) step before which each person cannot be near."""
    before: Floats
    """(P, 2) h of bodies and of social spaces at the state before."""
    violation: Floats
    """(2, n) largest violation of each person."""
    wall_violation: Floats
    """(1,) largest violation of any disc of the footprint."""
    free: Floats
    """(2,): step when a person is due again, distance to go before a wall can be near."""


def workspace(scene: Scene, objective: Objective) -> Workspace:
    """A workspace for a scene."""
    count = len(scene.people.weight)
    return Workspace(
        np.zeros(FIRST_EXTRA + len(objective.extra.address)),
        np.zeros(count),
        np.zeros((count, 2)),
        np.zeros((2, scene.people.num_people)),
        np.zeros(1),
        np.zeros(2),
    )
