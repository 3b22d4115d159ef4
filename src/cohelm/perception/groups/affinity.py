"""Detectors of groups: clusters of pairs with evidence gathered over time, or no groups at all."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.config import Model
from cohelm.messages import Groups, People
from cohelm.perception.groups.agglomerative_clustering import cluster_people, inherit_ids
from cohelm.perception.groups.pair_evidence import (
    PairEvidence,
    PairEvidenceParameters,
    update_pair_evidence,
)
from cohelm.perception.sensor_clocks import CLOCK_RESET


class NoGroups:
    """Detects no groups; for comparison."""

    class Parameters(Model):
        """No parameters."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def group(self, people: People, memory: None = None) -> tuple[Groups, None]:
        """See :meth:`GroupDetector.group`."""
        return Groups.alone(len(people)), None


@value
class AffinityState:
    """Memory of pairs among m people by growing id, including those recently out of view."""

    time: float
    """s."""
    next_id: int
    """Next unused id of a group."""
    id: Annotated[Integers, Shape("m")]
    """Ids of the people."""
    seen: Annotated[Floats, Shape("m")]
    """Time at which each was last tracked, s."""
    group: Annotated[Integers, Shape("m")]
    """Id of each person's group, −1: alone."""
    log_odds: Annotated[Floats, Shape("m m")]
    """ln(p / (1 − p)) that two belong together."""
    relative_velocity: Annotated[Floats, Shape("m m 2")]
    """Running mean of the second's velocity relative to the first, m/s."""
    weight: Annotated[Floats, Shape("m m")]
    """Weight of that mean, 0…1; 0: never tracked together."""


class Affinity:
    """Groups from the log-odds of pairs: near and moving alike, or standing face to face.

    The log-odds of a pair accumulate and fade (``pair_evidence``), and are clustered
    (``agglomerative_clustering``), with a bonus for existing groups. Walking companions are found
    as soon as their velocities are known. Standing people with known headings are found by their
    common o-space, others by nearness alone, with less certainty.
    """

    class Parameters(Model):
        """Parameters of the detector; assumed where no source is named."""

        walking_prior: float = Field(-0.75, ge=-10.0, le=10.0)
        """Log-odds per observation that any two people who walk near each other are companions."""
        standing_prior: float = Field(-0.6, ge=-10.0, le=10.0)
        """Log-odds per observation that any two standing people belong together."""
        nearness: float = Field(1.75, ge=0.0, le=20.0)
        """Log-odds in favour at distance 0."""
        walking_distance: float = Field(1.8, gt=0.0, le=10.0)
        """Distance abreast at which nearness is neutral, m."""
        following_factor: float = Field(0.65, ge=0.0, le=10.0)
        """Additional weight of the squared distance along the direction of motion: strangers follow
        each other."""
        companion_deviation: float = Field(0.21, gt=0.0, le=2.0)
        """Deviation of companions' velocities from each other along one axis, m/s."""
        stranger_deviation: float = Field(0.7, ge=0.0, le=5.0)
        """Deviation of strangers' velocities from each other, in shares of the faster's speed."""
        half_weight_deviation: float = Field(0.3, gt=0.0, le=5.0)
        """Deviation of the measured difference of velocities along one axis at which an observation
        has half weight, m/s."""
        standing_distance: float = Field(1.6, gt=0.0, le=10.0)
        """Distance of two standing people at which nearness is neutral, m; with the prior, people
        up to 1.3 m apart form a group, a little more than Hall's personal distance of 1.2 m."""
        facing: float = Field(2.0, ge=0.0, le=20.0)
        """Log-odds in favour of two people who share the centre of their o-space."""
        o_space_offset: float = Field(0.7, ge=0.0, le=3.0)
        """Distance of a person to the centre of the o-space, m (Kendon; Cristani 2011)."""
        o_space_distance: float = Field(1.3, gt=0.0, le=5.0)
        """Distance of two centres of o-spaces that is neutral, m."""
        behind: float = Field(4.0, ge=0.0, le=50.0)
        """Log-odds against two people of whom one has the other directly behind."""
        standing_speed: float = Field(0.3, ge=0.0, le=3.0)
        """Slower people are standing, m/s."""
        first_look: float = Field(0.3, ge=0.0, le=10.0)
        """Duration that the first observation of a pair counts for, s."""
        longest_look: float = Field(1.0, gt=0.0, le=10.0)
        """Longest duration that a later one counts for, s."""
        drift_time: float = Field(1.3, gt=0.0, le=60.0)
        """Time constant of the mean of the velocity difference, s: longer than a step's sway."""
        fading: float = Field(5.3, gt=0.0, le=1000.0)
        """Time constant with which evidence fades, s."""
        rate: float = Field(2.5, gt=0.0, le=100.0)
        """Independent observations per second."""
        max_evidence: float = Field(4.5, gt=0.0, le=100.0)
        """Bound of the evidence of one observation, either way."""
        max_log_odds: float = Field(3.0, gt=0.0, le=100.0)
        """Bound of the log-odds, either way: limits the evidence that a change has to outweigh."""
        join_log_odds: float = Field(1.0, ge=-10.0, le=10.0)
        """Log-odds above which people are joined."""
        linkage: float = Field(0.25, ge=0.0, le=1.0)
        """Influence of the strongest pair of two clusters: 0 average, 1 single linkage."""
        membership_bonus: float = Field(1.4, ge=0.0, le=10.0)
        """Log-odds added for members of one group, which prevents flicker."""
        memory_time: float = Field(3.0, ge=0.0, le=60.0)
        """Time out of view after which a person is forgotten, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = p = parameters or self.Parameters()
        self._pair_parameters = PairEvidenceParameters(
            *(getattr(p, name) for name in PairEvidenceParameters._fields)
        )

    def group(self, people: People, memory: AffinityState | None) -> tuple[Groups, AffinityState]:
        """See :meth:`GroupDetector.group`; the ids of ``people`` must differ."""
        p = self.parameters
        order = np.argsort(people.id, kind="stable")
        before = _recalled(memory, people.time, people.id[order], p.memory_time)
        here = np.searchsorted(before.id, people.id[order])
        all_here = len(here) == len(before.id)
        block: Any = np.s_[:, :] if all_here else np.ix_(here, here)
        since = people.time - memory.time if memory else 0.0
        velocity = people.covariance[order, 2:, 2:]
        evidence = update_pair_evidence(
            people.mean[order],
            0.5 * (velocity[:, 0, 0] + velocity[:, 1, 1]),
            people.heading[order],
            min(max(since, 0.0), p.longest_look),
            PairEvidence(
                np.array(before.log_odds[block]),
                np.array(before.relative_velocity[block]),
                np.array(before.weight[block]),
            ),
            self._pair_parameters,
        )
        old = before.group[here]
        together = (old[:, None] == old) & (old[:, None] >= 0)
        label = cluster_people(
            evidence.log_odds + p.membership_bonus * together - p.join_log_odds, p.linkage
        )
        group, next_id = inherit_ids(label, old, before.next_id)
        kept = group
        if not all_here:  # the other members of a group may only be out of view
            waits = (group < 0) & np.isin(old, np.delete(before.group, here)) & (old >= 0)
            kept = np.where(waits, old, group)
        state = replace(
            _with_evidence(before, here, evidence),
            time=max(people.time, before.time),
            next_id=next_id,
            seen=_with_rows(before.seen, here, max(people.time, before.time)),
            group=_with_rows(before.group, here, kept),
        )
        grouped = group >= 0
        member = np.full(len(people), -1)
        ids = group[grouped]
        if len(ids):
            ids, member[order[grouped]] = np.unique(ids, return_inverse=True)
        return Groups(id=ids, member=member), state


def _recalled(
    memory: AffinityState | None, time: float, ids: Integers, memory_time: float
) -> AffinityState:
    """Memory with rows for all ``ids`` in order, without people out of view for too long."""
    if memory is None or time < memory.time - CLOCK_RESET:
        return _blank(time, memory.next_id if memory else 0, ids)
    time = max(time, memory.time)
    if np.array_equal(memory.id, ids):
        return memory
    kept = np.isin(memory.id, ids) | (memory.seen >= time - memory_time)
    state = _blank(time, memory.next_id, np.union1d(ids, memory.id[kept]))
    at, old = np.searchsorted(state.id, memory.id[kept]), np.ix_(kept, kept)
    evidence = PairEvidence(memory.log_odds[old], memory.relative_velocity[old], memory.weight[old])
    return replace(
        _with_evidence(state, at, evidence),
        seen=_with_rows(state.seen, at, memory.seen[kept]),
        group=_with_rows(state.group, at, memory.group[kept]),
    )


def _blank(time: float, next_id: int, ids: Integers) -> AffinityState:
    """Memory of new people."""
    m = len(ids)
    return AffinityState(
        time=time,
        next_id=next_id,
        id=ids,
        seen=np.full(m, time),
        group=np.full(m, -1),
        log_odds=np.zeros((m, m)),
        relative_velocity=np.zeros((m, m, 2)),
        weight=np.zeros((m, m)),
    )


def _with_rows(rows: Any, at: Any, new: Any) -> Any:
    """Copy of ``rows`` with new ones at some indices."""
    out = rows.copy()
    out[at] = new
    return out


def _with_evidence(state: AffinityState, at: Integers, evidence: PairEvidence) -> AffinityState:
    """``state`` with the evidence of the pairs among the rows ``at``."""
    if len(at) < len(state.id):
        block = np.ix_(at, at)
        new = evidence._asdict().items()
        evidence = PairEvidence(*(_with_rows(getattr(state, k), block, rows) for k, rows in new))
    return replace(state, **evidence._asdict())
