"""How well people were told who are really there: identities, and errors of place and velocity.

Somebody who cannot be asked for — too far, hidden — is neither missed nor invented: whoever is told
at such a person is left out of the count, as is who is told farther away than anybody is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.evaluation.mot import Compared, Identities, identities
from cohelm.messages import People

WITHIN = 0.5
"""Farthest that somebody told may be from where somebody is and still be them, m."""
LEAST_VISIBLE = 0.3
"""Share of the body from which on a person has to be told."""


@value
class TruePeople:
    """Who truly is there at one instant; n people."""

    time: float
    """s."""
    id: Annotated[Integers, Shape("n")]
    position: Annotated[Floats, Shape("n 2")]
    """Map frame, m."""
    velocity: Annotated[Floats, Shape("n 2")]
    """m/s; NaN: not known."""
    visible: Annotated[Floats, Shape("n")]
    """Share of the body that the sensors could see, 0…1."""
    asked: Annotated[Booleans, Shape("n")]
    """Who has to be told; the others may be."""
    centre: Annotated[Floats, Shape("2")]
    """Of what is looked at, m."""
    reach: float = np.inf
    """How far from there it extends, m: whoever is told beyond, where nobody is, does not count."""


@value
class TrackingScores:
    """What was made of f frames with s sightings of people who were asked for."""

    identities: Identities
    """MOTA, IDF1 and their counts."""
    frames: int
    frame: Annotated[Integers, Shape("s")]
    """Index of each sighting's frame."""
    person: Annotated[Integers, Shape("s")]
    """True id."""
    position: Annotated[Floats, Shape("s 2")]
    """True, m."""
    visible: Annotated[Floats, Shape("s")]
    """Share of the body."""
    told: Annotated[Integers, Shape("s")]
    """Id that the person was told under, −1: missed."""
    offset: Annotated[Floats, Shape("s 2")]
    """Told less true position, m; NaN where missed."""
    slip: Annotated[Floats, Shape("s 2")]
    """Told less true velocity, m/s; NaN where missed."""
    invented: Annotated[Floats, Shape("i 4")]
    """(frame, id, x, y) of everyone told where nobody is."""
    claims: Annotated[Floats, Shape("c 2")]
    """(confidence, 1 where somebody is) of everyone told in any frame."""

    @property
    def position_error(self) -> float:
        """Mean over the sightings told, m; NaN without any."""
        return _mean_length(self.offset)

    @property
    def velocity_error(self) -> float:
        """Mean length of the velocity's error over the sightings told, m/s; NaN without any."""
        return _mean_length(self.slip)

    @property
    def calibration(self) -> Floats:
        """(10, 3): told confidence in tenths: its mean, the share that were people, how many."""
        bins = np.minimum((10.0 * self.claims[:, 0]).astype(np.int64), 9)
        count = np.bincount(bins, minlength=10)
        with np.errstate(invalid="ignore"):
            means = [np.bincount(bins, column, 10) / count for column in self.claims.T]
        return np.stack([*means, count], axis=-1)


def tracking_scores(
    truth: Sequence[TruePeople], told: Sequence[People], *, within: float = WITHIN
) -> TrackingScores:
    """Scores of what was told in each frame against who was there.

    In each frame as many people as possible are matched, and so that the sum of their distances is
    least; the errors are those of these matches. py-motmetrics makes its own, in which an id once
    given is kept while it fits.

    Args:
        truth: f frames.
        told: the same frames.
        within: farthest match, m.

    Raises:
        PluginError: where py-motmetrics is not installed.
    """
    compared: list[Compared] = []
    rows: list[Floats] = [np.empty((0, 10))]
    invented, claims = [np.empty((0, 4))], [np.empty((0, 2))]
    for k, (true, people) in enumerate(zip(truth, told, strict=True)):
        match = _matches(true, people, within)
        near = np.hypot(*(people.mean[:, :2] - true.centre).T) <= true.reach
        nobody = np.setdiff1d(np.flatnonzero(near), match)
        counted = np.union1d(nobody, match[true.asked & (match >= 0)])
        compared.append(
            Compared(
                true_id=true.id[true.asked],
                true=true.position[true.asked],
                told_id=people.id[counted],
                told=people.mean[counted, :2],
            )
        )
        rows.append(_sightings(k, true, people, match))
        alone = np.full(len(nobody), float(k))
        invented.append(np.column_stack([alone, people.id[nobody], people.mean[nobody, :2]]))
        right = np.isin(np.arange(len(people)), match)
        claims.append(np.column_stack([people.confidence, right]))
    table = np.concatenate(rows)
    return TrackingScores(
        identities=identities(compared, within),
        frames=len(compared),
        frame=table[:, 0].astype(np.int64),
        person=table[:, 1].astype(np.int64),
        told=table[:, 2].astype(np.int64),
        visible=table[:, 3],
        position=table[:, 4:6],
        offset=table[:, 6:8],
        slip=table[:, 8:],
        invented=np.concatenate(invented),
        claims=np.concatenate(claims),
    )


def _matches(true: TruePeople, people: People, within: float) -> Integers:
    """Index of whom each true person (n,) was told as, −1: nobody."""
    offset = true.position[:, None] - people.mean[None, :, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    near = distance <= within
    rows, cols = linear_sum_assignment(np.where(near, distance, 1e3))
    match = np.full(len(true.id), -1)
    match[rows] = np.where(near[rows, cols], cols, -1)
    return match


def _sightings(k: int, true: TruePeople, people: People, match: Integers) -> Floats:
    """(s, 10): frame, person, told id, visible, position, offset and slip of those asked for."""
    asked = np.flatnonzero(true.asked)
    found = match[asked] >= 0
    mean = np.full((len(asked), 4), np.nan)
    mean[found] = people.mean[match[asked[found]]]
    told = np.full(len(asked), -1)
    told[found] = people.id[match[asked[found]]]
    return np.column_stack(
        [
            np.full(len(asked), k),
            true.id[asked],
            told,
            true.visible[asked],
            true.position[asked],
            mean[:, :2] - true.position[asked],
            mean[:, 2:] - true.velocity[asked],
        ]
    )


def _mean_length(vectors: Floats) -> float:
    length = np.hypot(vectors[:, 0], vectors[:, 1])
    known = length[np.isfinite(length)]
    return float(known.mean()) if len(known) else float("nan")
