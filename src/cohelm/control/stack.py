"""The stack of an objective: the parameters of all its terms and barriers, and their tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from cohelm.config import Model
from cohelm.control.api import LocalProblem
from cohelm.control.objective import start_values
from cohelm.control.objective_tables import Objective
from cohelm.control.scene import Scene
from cohelm.control.terms import (
    Barrier,
    ExtraTerm,
    FinalHeading,
    GroupSpace,
    InputChange,
    InputEffort,
    PathDistance,
    PersonalSpaceCost,
    PersonClearance,
    Progress,
    TrackReference,
    WallClearance,
)
from cohelm.control.terms.barrier import REACH
from cohelm.control.terms.extra import extra_table

_NORMS = {1: 1, 2: 2, "inf": 0}


class Terms(Model):
    """Terms and barriers of the one objective, all in seconds; a weight of 0 removes a term."""

    progress: Progress = Progress()
    path_distance: PathDistance = PathDistance()
    final_heading: FinalHeading = FinalHeading()
    input_effort: InputEffort = InputEffort()
    input_change: InputChange = InputChange()
    track_reference: TrackReference = TrackReference()
    person_clearance: PersonClearance = PersonClearance()
    personal_space: PersonalSpaceCost = PersonalSpaceCost()
    group_space: GroupSpace = GroupSpace()
    wall_clearance: WallClearance = WallClearance()
    bodies: Barrier = Barrier()
    social_space: Barrier = Barrier(gamma=0.15, l1=0.2, l2=0.2, min_probability=0.3)
    walls: Barrier = Barrier(gamma=1.0, l1=4.0, l2=4.0)

    def objective(
        self,
        scene: Scene,
        problem: LocalProblem,
        extra_terms: Sequence[ExtraTerm] = (),
        *,
        stride: int = 1,
        norm: Literal[1, 2, "inf"] = 2,
    ) -> Objective:
        """The tables of all terms for one scene.

        Args:
            scene: the scene.
            problem: from which the scene was made.
            extra_terms: terms of one's own.
            stride: steps of the plan in one step of the scene.
            norm: of distances to bodies.
        """
        people, kind = scene.people, _NORMS[norm]
        spaces = people.extent if self.personal_space.weight > 0.0 else 0.0
        widest = max(people.largest_margin, spaces)
        if self.bodies.l1 > 0.0 or self.bodies.l2 > 0.0:
            widest = max(widest, people.largest_margin + REACH)
        if self.social_space.l1 > 0.0 or self.social_space.l2 > 0.0:
            widest = max(widest, people.extent + people.own_extent + REACH)
        return Objective(
            progress=self.progress.table(scene),
            path=self.path_distance.table(scene),
            heading=self.final_heading.table(scene),
            effort=self.input_effort.table(scene),
            change=self.input_change.table(scene),
            track=self.track_reference.table(scene),
            person=self.person_clearance.table(scene),
            space=self.personal_space.table(scene),
            group=self.group_space.table(scene),
            wall=self.wall_clearance.table(scene),
            bodies=self.bodies.table(scene, stride, kind),
            social=self.social_space.table(scene, stride),
            walls=self.walls.table(scene, stride),
            extra=extra_table(extra_terms, problem, scene),
            start=start_values(scene, kind),
            widest=widest,
        )
