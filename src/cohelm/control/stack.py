"""The stack of an objective: the parameters of all its terms and barriers, and their tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from cohelm.config import Model
from cohelm.control.api import LocalProblem
from cohelm.control.objective import start_values
from cohelm.control.objective_tables import Objective
from cohelm.control.people_table import PeopleTable
from cohelm.control.scene import Scene
from cohelm.control.terms import (
    Barrier,
    ExtraTerm,
    FinalHeading,
    GroupSpace,
    InputChange,
    InputDeviation,
    InputEffort,
    PathDistance,
    PersonalSpaceCost,
    PersonClearance,
    Progress,
    TrackReference,
    WallBarrier,
    WallClearance,
)
from cohelm.control.terms.barrier import REACH
from cohelm.control.terms.extra import extra_table

_SPACES_FROM = 0.3
"""Probability from which the space of a less likely hypothesis counts. Its body never does: a
person who may turn towards the robot gets space, but is not yet an obstacle."""
_NO_TRACKING = TrackReference()
_NORMS = {1: 1, 2: 2, "inf": 0}


class Terms(Model):
    """Terms and barriers of the one objective, all in seconds; a weight of 0 removes a term."""

    progress: Progress = Progress()
    path_distance: PathDistance = PathDistance()
    final_heading: FinalHeading = FinalHeading()
    input_effort: InputEffort = InputEffort()
    input_change: InputChange = InputChange()
    person_clearance: PersonClearance = PersonClearance()
    personal_space: PersonalSpaceCost = PersonalSpaceCost()
    group_space: GroupSpace = GroupSpace()
    wall_clearance: WallClearance = WallClearance()
    bodies: Barrier = Barrier()
    social_space: Barrier = Barrier(gamma=0.15, l1=0.2, l2=0.2)
    walls: WallBarrier = WallBarrier(l1=4.0, l2=4.0)

    @property
    def tracking(self) -> TrackReference:
        """No tracking: the path counts, and not the time at which a pose is reached."""
        return _NO_TRACKING

    def objective(
        self,
        scene: Scene,
        problem: LocalProblem,
        extra_terms: Sequence[ExtraTerm] = (),
        *,
        norm: Literal[1, 2, "inf"] = 2,
    ) -> Objective:
        """The tables of all terms for one scene.

        Args:
            scene: the scene.
            problem: from which the scene was made.
            extra_terms: terms of one's own.
            norm: of distances to bodies.
        """
        kind = _NORMS[norm]
        return Objective(
            **self._terms(scene),
            bodies=self.bodies.table(scene, norm=kind),
            social=self.social_space.table(scene, min_probability=_SPACES_FROM),
            walls=self.walls.table(),
            extra=extra_table(extra_terms, problem, scene),
            start=start_values(scene, kind),
            widest=self._widest(scene.people),
        )

    def coarser(self, objective: Objective, scene: Scene, stride: int) -> Objective:
        """The objective for a scene with ``stride`` steps in one; people are where they are."""
        return objective._replace(
            **self._terms(scene),
            bodies=self.bodies.coarser(objective.bodies, stride),
            social=self.social_space.coarser(objective.social, stride),
            extra=objective.extra._replace(step=scene.step),
        )

    def _terms(self, scene: Scene) -> dict[str, Any]:
        """The tables that depend on the steps of the scene, by their name in ``Objective``."""
        return {
            "progress": self.progress.table(scene),
            "path": self.path_distance.table(scene),
            "heading": self.final_heading.table(scene),
            "effort": self.input_effort.table(scene),
            "change": self.input_change.table(scene),
            "track": self.tracking.table(scene),
            "person": self.person_clearance.table(scene),
            "space": self.personal_space.table(scene),
            "group": self.group_space.table(scene),
            "wall": self.wall_clearance.table(scene),
        }

    def _widest(self, people: PeopleTable) -> float:
        """A person farther away than this has no cost, m."""
        widest = people.largest_margin
        if self.personal_space.weight > 0.0:
            widest = max(widest, people.extent)
        if self.bodies.is_active:
            widest = max(widest, people.largest_margin + REACH)
        if self.social_space.is_active:
            widest = max(widest, people.extent + people.own_extent + REACH)
        return widest


class TrackingTerms(Terms):
    """The objective of planners that track the reference's poses and inputs, eq. (12)."""

    input_effort: InputDeviation = InputDeviation()
    track_reference: TrackReference = TrackReference()

    @property
    def tracking(self) -> TrackReference:
        """Tracking of the reference's poses."""
        return self.track_reference
