"""Detectors of groups: clusters of pairs with evidence gathered over time, or no groups at all.

Positions, motion and headings are evidence that two people belong together; clusters of such pairs
are groups, which keep their ids.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, replace, sealed, value
from cohelm.config import Model
from cohelm.kernels import CACHED, callee
from cohelm.messages import Groups, People
from cohelm.perception.sensor_clocks import CLOCK_RESET


class PairEvidenceParameters(NamedTuple):
    """The part of ``Affinity.Parameters`` that the kernels use; described there."""

    walking_prior: float
    standing_prior: float
    nearness: float
    walking_distance: float
    following_factor: float
    companion_deviation: float
    stranger_deviation: float
    standing_distance: float
    facing: float
    o_space_offset: float
    o_space_distance: float
    behind: float
    standing_speed: float
    first_look: float
    drift_time: float
    fading: float
    rate: float
    max_log_odds: float


class PairEvidence(NamedTuple):
    """Evidence of all pairs among n people."""

    log_odds: Floats
    """(n, n)."""
    relative_velocity: Floats
    """(n, n, 2) running mean of the second's velocity relative to the first, m/s."""
    weight: Floats
    """(n, n) weight of that mean, 0…1; 0: never observed together."""


@callee()
def update_pair_evidence(
    state: Floats,
    heading: Floats,
    since: float,
    before: PairEvidence,
    w: PairEvidenceParameters,
) -> PairEvidence:
    """Evidence of all pairs after one more observation.

    L ← clip(L e^(−Δt / fading) + Δt · rate · e), e from :func:`walking_evidence` or
    :func:`standing_evidence`; Δt = ``first_look`` for a new pair.

    Args:
        state: (n, 4), x, y, v_x, v_y; m and m/s.
        heading: (n,) rad; NaN where unknown.
        since: time since the last observation, s.
        before: earlier evidence.
        w: the parameters.
    """
    n = state.shape[0]
    L, D, W = before.log_odds.copy(), before.relative_velocity.copy(), before.weight.copy()
    forget, fade = math.exp(-since / w.fading), math.exp(-since / w.drift_time)
    first = math.exp(-w.first_look / w.drift_time)
    for i in range(n):
        for j in range(i + 1, n):
            known = before.weight[i, j] > 0.0
            span, keep = (since, fade) if known else (w.first_look, first)
            # Running mean of the difference of velocities.
            gain = 1.0 - keep
            W[i, j] = W[i, j] * keep + gain
            if gain > 0.0:
                for axis in range(2):
                    apart = state[j, 2 + axis] - state[i, 2 + axis]
                    D[i, j, axis] += gain / W[i, j] * (apart - D[i, j, axis])
            # Evidence of this observation.
            one = math.hypot(state[i, 2], state[i, 3])
            other = math.hypot(state[j, 2], state[j, 3])
            if one < w.standing_speed and other < w.standing_speed:
                e = standing_evidence(state[i], state[j], heading[i], heading[j], w)
            else:
                relative_speed_sq = D[i, j, 0] ** 2 + D[i, j, 1] ** 2
                e = walking_evidence(state[i], state[j], relative_speed_sq, max(one, other), w)
            kept = L[i, j] * forget if known else 0.0
            L[i, j] = min(max(kept + span * w.rate * e, -w.max_log_odds), w.max_log_odds)
            # The matrices are symmetric, the relative velocity antisymmetric.
            L[j, i], W[j, i] = L[i, j], W[i, j]
            D[j, i, 0], D[j, i, 1] = -D[i, j, 0], -D[i, j, 1]
    return PairEvidence(L, D, W)


@callee()
def walking_evidence(
    one: Floats, other: Floats, relative_speed_sq: float, speed: float, w: PairEvidenceParameters
) -> float:
    """Evidence of two people of whom at least one walks, an approximate log-likelihood ratio.

    Companions stay near, and nearer one behind the other than side by side. The difference of
    their velocities is Gaussian with deviation s, that of strangers larger and growing with speed:

        e = prior + nearness (1 − (d² + f a²) / distance²) + ln(S²/s²) − u²/2 (1/s² − 1/S²)
        s = companion_deviation,  S² = s² + (stranger_deviation · speed)²,  f = following_factor

    with d their distance, a its part along their common direction and u their relative velocity.
    If both are slow, the velocities carry no information.

    Args:
        one, other: x, y, v_x, v_y; m and m/s.
        relative_speed_sq: u², m²/s².
        speed: of the faster person, m/s.
        w: the parameters.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    vx, vy = one[2] + other[2], one[3] + other[3]
    common = vx * vx + vy * vy
    along = (dx * vx + dy * vy) ** 2 / common if common > 1e-9 else 0.0
    near = 1.0 - (dx * dx + dy * dy + w.following_factor * along) / w.walking_distance**2
    s2 = w.companion_deviation**2
    S2 = s2 + (w.stranger_deviation * speed) ** 2
    same = math.log(S2 / s2) - 0.5 * relative_speed_sq * (1.0 / s2 - 1.0 / S2)
    total: float = w.walking_prior + w.nearness * near + same
    return total


@callee()
def standing_evidence(
    one: Floats, other: Floats, facing: float, other_facing: float, w: PairEvidenceParameters
) -> float:
    """Evidence of two standing people: a common o-space, or nearness if a heading is unknown.

    The centre of the o-space of an F-formation (Kendon) lies ``o_space_offset`` ahead of each
    member. Two people share it if their centres are near each other and neither is behind:

        e = prior + facing (1 − o² / o_space_distance²)
            − behind (max(−¼ − cos β, 0) + max(−¼ − cos β', 0))

    with o the distance of the centres and β the bearing of the other; −cos β > ¼ is behind the
    shoulders. With an unknown heading,
    e = prior + nearness (1 − d² / standing_distance²).
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    d = math.hypot(dx, dy)
    if math.isnan(facing) or math.isnan(other_facing):
        return w.standing_prior + w.nearness * (1.0 - (d / w.standing_distance) ** 2)
    cx, cy = math.cos(facing), math.sin(facing)
    ox, oy = math.cos(other_facing), math.sin(other_facing)
    apart = math.hypot(dx + w.o_space_offset * (ox - cx), dy + w.o_space_offset * (oy - cy))
    ahead = (cx * dx + cy * dy) / max(d, 1e-9)
    other_ahead = -(ox * dx + oy * dy) / max(d, 1e-9)
    turned = max(-0.25 - ahead, 0.0) + max(-0.25 - other_ahead, 0.0)
    total: float = w.standing_prior + w.facing * (1.0 - (apart / w.o_space_distance) ** 2)
    total -= w.behind * turned
    return total


@njit(**CACHED)
def cluster_people(evidence: Floats, linkage: float) -> Integers:
    """Cluster n people; the label (n,) of a cluster is the index of its first member.

    The two clusters with the largest link are joined, as long as it is positive:

        (1 − linkage) · mean + linkage · max   of the evidence of all pairs between them

    Average linkage (0) separates chains of strangers; single linkage (1) finds all of a long row,
    whose ends are joined only by their neighbours.

    Args:
        evidence: (n, n) of each pair, symmetric; the diagonal is ignored.
        linkage: 0…1.
    """
    n = evidence.shape[0]
    label, total, most = np.arange(n), evidence.copy(), evidence.copy()
    size, alive = np.ones(n), np.ones(n, dtype=np.bool_)
    while True:
        best, a, b = 0.0, -1, -1
        for i in range(n):
            if not alive[i]:
                continue
            for j in range(i + 1, n):
                if alive[j]:
                    mean = total[i, j] / (size[i] * size[j])
                    link = (1.0 - linkage) * mean + linkage * most[i, j]
                    if link > best:
                        best, a, b = link, i, j
        if a < 0:
            return label
        for k in range(n):
            total[a, k] += total[b, k]
            total[k, a] = total[a, k]
            most[a, k] = max(most[a, k], most[b, k])
            most[k, a] = most[a, k]
            if label[k] == b:
                label[k] = a
        size[a] += size[b]
        alive[b] = False


@njit(**CACHED)
def inherit_ids(label: Integers, before: Integers, next_id: int) -> tuple[Integers, int]:
    """(id of each person's group (n,), −1: alone; the next unused id).

    A cluster inherits the id that most of its members had. If two clusters claim one id, the one
    with more of its members gets it, so that after merges and splits the larger part keeps the id.
    Other clusters get new ids.

    Args:
        label: (n,) cluster of each person: the index of its first member.
        before: (n,) earlier group id of each person, −1: none.
        next_id: larger than any id used so far.
    """
    n = label.shape[0]
    size, group, open_claim = np.zeros(n, dtype=np.int64), np.full(n, -1), np.zeros(n, np.bool_)
    for i in range(n):
        size[label[i]] += 1
    for i in range(n):
        open_claim[i] = before[i] >= 0 and size[label[i]] > 1
    while True:
        heir, kept = _strongest(label, before, open_claim)
        if heir < 0:
            break
        for i in range(n):
            if label[i] == heir:
                group[i] = kept
            if label[i] == heir or before[i] == kept:
                open_claim[i] = False
    for k in range(n):
        if size[k] > 1 and group[k] < 0:
            for i in range(n):
                if label[i] == k:
                    group[i] = next_id
            next_id += 1
    return group, next_id


@callee()
def _strongest(label: Integers, before: Integers, open_claim: Booleans) -> tuple[int, int]:
    """(cluster, id) that share the most people; the oldest id among equals, −1 without a claim."""
    most, heir, kept = 0, -1, -1
    for k in range(len(label)):
        if not open_claim[k]:
            continue
        common = 0
        for i in range(len(label)):
            common += label[i] == label[k] and before[i] == before[k]
        if common > most or (common == most and before[k] < kept):
            most, heir, kept = common, label[k], before[k]
    return heir, kept


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
        ids = np.sort(people.id)
        before = _recalled(memory, people.time, ids, p.memory_time)
        since = people.time - memory.time if memory else 0.0
        time = max(people.time, before.time)
        updated = sealed(
            _regroup(
                _People(people.id, people.mean, people.heading),
                _Past(*(getattr(before, name) for name in _Past._fields)),
                (float(time), min(max(float(since), 0.0), p.longest_look)),
                before.next_id,
                (p.membership_bonus, p.join_log_odds, p.linkage),
                self._pair_parameters,
            )
        )
        columns = {name: getattr(updated, name) for name in _Past._fields}
        state = AffinityState(time=time, next_id=updated.next_id, **columns)
        return Groups(id=updated.group_id, member=updated.member), state


class _People(NamedTuple):
    """Columns of ``People``."""

    id: Integers
    mean: Floats
    heading: Floats


class _Past(NamedTuple):
    """Columns of ``AffinityState``."""

    id: Integers
    seen: Floats
    group: Integers
    log_odds: Floats
    relative_velocity: Floats
    weight: Floats


class _Update(NamedTuple):
    """Columns of the next ``AffinityState``, and of ``Groups``."""

    id: Integers
    seen: Floats
    group: Integers
    log_odds: Floats
    relative_velocity: Floats
    weight: Floats
    next_id: int
    group_id: Integers
    member: Integers


@njit(**CACHED)
def _regroup(
    people: _People,
    past: _Past,
    times: tuple[float, float],
    next_id: int,
    joining: tuple[float, float, float],
    w: PairEvidenceParameters,
) -> _Update:
    """Update evidence and groups with n people, who all have a row in the past.

    Args:
        people: in any order.
        past: m ≥ n rows by growing id.
        times: (now, time since the last observation), s.
        next_id: next unused id of a group.
        joining: (membership bonus, log-odds of joining, linkage).
        w: parameters of the evidence.
    """
    (bonus, join_log_odds, linkage), n = joining, len(people.id)
    who, row = _matched_rows(people.id, past.id)
    # People and evidence by growing id, without those out of view.
    mean, heading = np.empty((n, 4)), np.empty(n)
    before = PairEvidence(np.empty((n, n)), np.empty((n, n, 2)), np.empty((n, n)))
    for i in range(n):
        mean[i], heading[i] = people.mean[who[i]], people.heading[who[i]]
        for j in range(n):
            before.log_odds[i, j] = past.log_odds[row[i], row[j]]
            before.relative_velocity[i, j] = past.relative_velocity[row[i], row[j]]
            before.weight[i, j] = past.weight[row[i], row[j]]
    evidence = update_pair_evidence(mean, heading, times[1], before, w)
    # Clusters, with a bonus for members of one group.
    old, links = past.group[row], np.empty((n, n))
    for i in range(n):
        for j in range(n):
            together = old[i] == old[j] and old[i] >= 0
            links[i, j] = evidence.log_odds[i, j] + (bonus if together else 0.0) - join_log_odds
    group, next_id = inherit_ids(cluster_people(links, linkage), old, next_id)
    # The next state: rows of people out of view stay.
    log_odds, weight = past.log_odds.copy(), past.weight.copy()
    relative, kept, seen = past.relative_velocity.copy(), past.group.copy(), past.seen.copy()
    for i in range(n):
        seen[row[i]] = times[0]
        if group[i] >= 0 or not _waits(old[i], past.group, row):
            kept[row[i]] = group[i]
        for j in range(n):
            log_odds[row[i], row[j]] = evidence.log_odds[i, j]
            relative[row[i], row[j]] = evidence.relative_velocity[i, j]
            weight[row[i], row[j]] = evidence.weight[i, j]
    group_id, member = _members(group, who)
    return _Update(
        past.id.copy(), seen, kept, log_odds, relative, weight, next_id, group_id, member
    )


@callee()
def _matched_rows(ids: Integers, known: Integers) -> tuple[Integers, Integers]:
    """(index in ``ids`` (n,) by growing id, row of each of these in ``known``, which grow)."""
    who, row = np.empty(len(ids), dtype=np.int64), np.empty(len(ids), dtype=np.int64)
    n = 0
    for k in range(len(known)):
        for i in range(len(ids)):
            if ids[i] == known[k]:
                who[n], row[n] = i, k
                n += 1
    return who, row


@callee()
def _waits(group: int, groups: Integers, here: Integers) -> bool:
    """Check that a former member of ``group`` is out of view, so that the group may still exist.

    Args:
        group: id of the group, −1: none.
        groups: (m,) group of everyone.
        here: (n,) rows of the people in view, growing.
    """
    k = 0
    for other in range(len(groups)):
        if k < len(here) and here[k] == other:
            k += 1
        elif groups[other] == group and group >= 0:
            return True
    return False


@callee()
def _members(group: Integers, who: Integers) -> tuple[Integers, Integers]:
    """(ids of the groups (g,), growing; index of each person's group (n,), −1: alone).

    Args:
        group: (n,) id of each person's group, −1: alone.
        who: (n,) index of each of these people.
    """
    ids, member, count = np.empty(len(group), dtype=np.int64), np.full(len(group), -1), 0
    for i in range(len(group)):
        if group[i] < 0:
            continue
        k = 0
        while k < count and ids[k] < group[i]:
            k += 1
        if k == count or ids[k] != group[i]:
            ids[k + 1 : count + 1] = ids[k:count].copy()
            ids[k] = group[i]
            count += 1
    for i in range(len(group)):
        for k in range(count):
            if ids[k] == group[i]:
                member[who[i]] = k
    return ids[:count], member


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
    new = np.ix_(at, at)
    return replace(
        state,
        seen=_with_rows(state.seen, at, memory.seen[kept]),
        group=_with_rows(state.group, at, memory.group[kept]),
        log_odds=_with_rows(state.log_odds, new, memory.log_odds[old]),
        relative_velocity=_with_rows(state.relative_velocity, new, memory.relative_velocity[old]),
        weight=_with_rows(state.weight, new, memory.weight[old]),
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
