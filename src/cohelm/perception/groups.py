"""Who belongs together: evidence about every pair, gathered over time, and clusters of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.config import Model
from cohelm.messages import Groups, People
from cohelm.perception.clock import RAN_BACK
from cohelm.perception.groups_evidence import Weighing, gather
from cohelm.perception.groups_joining import clusters, inherit


@value
class AffinityState:
    """What is known of the pairs among m people, by growing id; those lately out of view too."""

    time: float
    """s."""
    next_id: int
    """No group has had this id or a larger one."""
    id: Annotated[Integers, Shape("m")]
    """Of the people."""
    seen: Annotated[Floats, Shape("m")]
    """When each was last there, s."""
    group: Annotated[Integers, Shape("m")]
    """Id of each one's group, −1: alone."""
    log_odds: Annotated[Floats, Shape("m m")]
    """That two belong together: ln(p / (1 − p))."""
    drift: Annotated[Floats, Shape("m m 2")]
    """Running mean of the second's velocity as seen from the first, m/s."""
    weight: Annotated[Floats, Shape("m m")]
    """Of that mean, 0…1; 0: never seen together."""


class Affinity:
    """Groups from the log-odds of every pair: near and moving alike, or standing face to face.

    What a pair shows is gathered as log-odds that fade (``groups_evidence``), and those are
    clustered (``groups_joining``), with some credit for who already belongs together. Walking
    companions are found as soon as their velocities are known; people who stand and whose heading
    is known are found by their common o-space, others by nearness alone, less surely.
    """

    class Parameters(Model):
        """Of the detector; assumed where no source is named."""

        walking_prior: float = Field(-0.75, ge=-10.0, le=10.0)
        """Log-odds per look that any two who walk near each other are companions."""
        standing_prior: float = Field(-0.6, ge=-10.0, le=10.0)
        """The same of two who stand."""
        nearness: float = Field(1.75, ge=0.0, le=20.0)
        """Log-odds in favour where the distance is 0."""
        walking_distance: float = Field(1.8, gt=0.0, le=10.0)
        """Distance abreast at which nearness speaks neither for nor against, m."""
        in_file: float = Field(0.65, ge=0.0, le=10.0)
        """By how much more a distance along the way counts than one across, squared: strangers
        follow each other."""
        unison: float = Field(0.21, gt=0.0, le=2.0)
        """Deviation of companions' velocities from each other along one axis, m/s."""
        strangers: float = Field(0.7, ge=0.0, le=5.0)
        """Deviation of strangers' velocities from each other, in shares of the faster's speed."""
        certain: float = Field(0.3, gt=0.0, le=5.0)
        """Deviation of the measured difference of velocities along one axis with which a look at
        it counts half, m/s."""
        standing_distance: float = Field(1.6, gt=0.0, le=10.0)
        """Distance between two who stand at which nearness speaks neither way, m; with the prior,
        people up to 1.3 m apart are taken for a group, a little more than Hall's personal
        distance of 1.2 m."""
        facing: float = Field(2.0, ge=0.0, le=20.0)
        """Log-odds in favour where two look at the same middle."""
        stride: float = Field(0.7, ge=0.0, le=3.0)
        """From a person to the middle of the o-space before them, m (Kendon; Cristani 2011)."""
        shared: float = Field(1.3, gt=0.0, le=5.0)
        """Distance between two o-spaces' middles at which it speaks neither way, m."""
        behind: float = Field(4.0, ge=0.0, le=50.0)
        """Log-odds against where one has the other right behind."""
        standing: float = Field(0.3, ge=0.0, le=3.0)
        """People slower than this stand, m/s."""
        first_look: float = Field(0.3, ge=0.0, le=10.0)
        """A first look counts like one of so long, s."""
        longest_look: float = Field(1.0, gt=0.0, le=10.0)
        """Nor does any later one count for longer, s."""
        drift_time: float = Field(1.3, gt=0.0, le=60.0)
        """Time constant of the mean of the velocity difference, s: longer than a step's sway."""
        fading: float = Field(5.3, gt=0.0, le=1000.0)
        """Time constant with which evidence fades, s."""
        rate: float = Field(2.5, gt=0.0, le=100.0)
        """Independent looks per second."""
        most: float = Field(4.5, gt=0.0, le=100.0)
        """Largest evidence of one look, either way."""
        largest: float = Field(3.0, gt=0.0, le=100.0)
        """Largest log-odds, either way: so much has to be disproved."""
        least: float = Field(1.0, ge=-10.0, le=10.0)
        """Log-odds above which people are joined."""
        chain: float = Field(0.25, ge=0.0, le=1.0)
        """How far one strong pair links two clusters: 0 average, 1 single linkage."""
        credit: float = Field(1.4, ge=0.0, le=10.0)
        """Log-odds added for two who are in a group already: it does not flicker."""
        remembered: float = Field(3.0, ge=0.0, le=60.0)
        """Who has been out of view for longer is forgotten, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._weighing = Weighing(
            **{name: getattr(self.parameters, name) for name in Weighing._fields}
        )

    def group(self, people: People, memory: AffinityState | None) -> tuple[Groups, AffinityState]:
        """See :meth:`GroupDetector.group`; the ids of ``people`` must differ."""
        p = self.parameters
        order = np.argsort(people.id, kind="stable")
        before = _at(memory, people.time, people.id[order], p.remembered)
        here = np.searchsorted(before.id, people.id[order])
        all_here = len(here) == len(before.id)
        block: Any = np.s_[:, :] if all_here else np.ix_(here, here)
        since = people.time - memory.time if memory else 0.0
        velocity = people.covariance[order, 2:, 2:]
        log_odds, drift, weight = gather(
            people.mean[order],
            0.5 * (velocity[:, 0, 0] + velocity[:, 1, 1]),
            people.heading[order],
            min(max(since, 0.0), p.longest_look),
            np.array(before.log_odds[block]),
            np.array(before.drift[block]),
            np.array(before.weight[block]),
            before.weight[block] > 0.0,
            self._weighing,
        )
        held = before.group[here]
        together = (held[:, None] == held) & (held[:, None] >= 0)
        label = clusters(log_odds + p.credit * together - p.least, p.chain)
        group, next_id = inherit(label, held, before.next_id)
        kept = group
        if not all_here:  # the others of a group may only be out of view
            waits = (group < 0) & np.isin(held, np.delete(before.group, here)) & (held >= 0)
            kept = np.where(waits, held, group)
        time = max(people.time, before.time)
        state = _with(before, here, time, kept, next_id, (log_odds, drift, weight))
        grouped = group >= 0
        told = np.full(len(people), -1)
        ids = group[grouped]
        if len(ids):
            ids, told[order[grouped]] = np.unique(ids, return_inverse=True)
        return Groups(id=ids, member=told), state


def _at(
    memory: AffinityState | None, time: float, ids: Integers, remembered: float
) -> AffinityState:
    """The memory with rows for all of ``ids``, grown in order; who is long gone is left out."""
    if memory is None or time < memory.time - RAN_BACK:
        return _blank(time, memory.next_id if memory else 0, ids)
    time = max(time, memory.time)
    if np.array_equal(memory.id, ids):
        return memory
    kept = np.isin(memory.id, ids) | (memory.seen >= time - remembered)
    state = _blank(time, memory.next_id, np.union1d(ids, memory.id[kept]))
    at = np.searchsorted(state.id, memory.id[kept])
    block, old = np.ix_(at, at), np.ix_(kept, kept)
    seen, group = state.seen.copy(), state.group.copy()
    log_odds, drift, weight = (each.copy() for each in (state.log_odds, state.drift, state.weight))
    seen[at], group[at] = memory.seen[kept], memory.group[kept]
    log_odds[block], drift[block] = memory.log_odds[old], memory.drift[old]
    weight[block] = memory.weight[old]
    return replace(state, seen=seen, group=group, log_odds=log_odds, drift=drift, weight=weight)


def _blank(time: float, next_id: int, ids: Integers) -> AffinityState:
    """Nothing known of these people yet."""
    m = len(ids)
    return AffinityState(
        time=time,
        next_id=next_id,
        id=ids,
        seen=np.full(m, time),
        group=np.full(m, -1),
        log_odds=np.zeros((m, m)),
        drift=np.zeros((m, m, 2)),
        weight=np.zeros((m, m)),
    )


def _with(
    before: AffinityState,
    here: Integers,
    time: float,
    group: Integers,
    next_id: int,
    evidence: tuple[Floats, Floats, Floats],
) -> AffinityState:
    """``before`` with what was found of the people in the rows ``here``."""
    seen, held = before.seen.copy(), before.group.copy()
    seen[here], held[here] = time, group
    log_odds, drift, weight = evidence
    if len(here) < len(before.id):
        block = np.ix_(here, here)
        log_odds, drift, weight = (
            each.copy() for each in (before.log_odds, before.drift, before.weight)
        )
        log_odds[block], drift[block], weight[block] = evidence
    return AffinityState(
        time=time,
        next_id=next_id,
        id=before.id,
        seen=seen,
        group=held,
        log_odds=log_odds,
        drift=drift,
        weight=weight,
    )
