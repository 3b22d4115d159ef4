"""The sensor's own way, from its readings alone: for recordings that say nothing of it.

A reading is compared with what earlier ones saw, not with the last one only, so that errors do not
add up from reading to reading. A sensor that has not moved for sure is exactly where it was.
"""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.config import Model
from cohelm.geometry import compose, inverse, wrap_angle
from cohelm.perception.outlines import Outline
from cohelm.perception.scan_matching import (
    Match,
    Reference,
    fit_at,
    match,
    nearby,
    reference_of,
    sorted_reference,
)
from cohelm.perception.scan_search import search


class Matching(StrEnum):
    """How sure the way is."""

    OK = "ok"
    """The reading fits what was seen before."""
    PARTLY = "partly"
    """It does, but says nothing of one direction at least, in which the last motion goes on."""
    HELD = "held"
    """It does not, for a moment, or says too little: who rested is taken to rest still."""
    ANEW = "anew"
    """It does not: a new part of the way begins, of which nobody knows where it lies."""


class EgoMotionParameters(Model):
    """Of the sensor's own motion; assumed where no reason is given."""

    noise: float = Field(0.02, gt=0.0, le=0.5)
    """Standard deviation of what is the same, seen twice, m."""
    least: int = Field(25, ge=3, le=1000)
    """Points that a reading must show; while it shows fewer, nothing speaks against resting."""
    overlap: float = Field(0.5, gt=0.0, le=1.0)
    """Share of its points that must lie where something was."""
    overlap_after_gap: float = Field(0.65, gt=0.0, le=1.0)
    """The same after a gap, when nothing is known of the motion since."""
    gap: float = Field(1.0, gt=0.0, le=60.0)
    """Time between two readings above which it is one, s."""
    patience: float = Field(1.0, ge=0.0, le=60.0)
    """For so long may something cover the view of a sensor at rest, s."""
    moved: float = Field(0.02, ge=0.0, le=0.5)
    """A sensor at rest has moved no less, m."""
    turned: float = Field(0.007, ge=0.0, le=0.5)
    """Nor turned by less, rad (0.4°)."""
    gain: float = Field(0.15, ge=0.0, le=5.0)
    """By how much, in squared standard deviations, a point must fit better in the mean for a sensor
    at rest to have moved."""
    sure_gain: float = Field(0.6, ge=0.0, le=9.0)
    """The same for a single reading to say so; else two must."""
    changed: float = Field(0.8, gt=0.0, le=1.0)
    """What a sensor at rest is compared with is taken anew where less of it is still seen,"""
    refresh: float = Field(5.0, gt=0.0, le=600.0)
    """but not more often than this, s: who creeps would be carried along."""
    calm: float = Field(0.6, gt=0.0, le=10.0)
    """Who has not moved for so long rests, s."""
    keyframe: float = Field(0.25, gt=0.0, le=5.0)
    """A reading is kept to compare with after so far, m."""
    keyframe_turn: float = Field(0.2, gt=0.0, le=3.0)
    """Or so much turning, rad."""
    kept: int = Field(25, ge=1, le=1000)
    """What was not seen in so many of these is forgotten."""
    spacing: float = Field(0.05, gt=0.0, le=1.0)
    """What lies this near to what is kept is not kept again, m."""
    reach: float = Field(1.6, ge=0.0, le=10.0)
    """Half the breadth of a search about where it should be, m."""
    turn: float = Field(0.5, ge=0.0, le=3.1)
    """The same of its headings, rad."""


@value
class Surroundings:
    """What is kept to compare with."""

    reference: Reference
    number: Annotated[Integers, Shape("k")]
    """Of the reading that each of its points is from."""
    latest: int
    """Number of the newest reading that is kept."""
    X_MR: Annotated[Floats, Shape("3")]
    """Where that was taken."""


@value
class Way:
    """Where a sensor's robot is by now, and what the next reading is compared with."""

    time: float
    """Of the last reading, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR; M is the robot's frame at the first reading."""
    twist: Annotated[Floats, Shape("3")]
    """Since the reading before, robot frame."""
    matching: Matching
    overlap: float
    """Share of the reading that lies on what was seen before, 0…1."""
    part: int
    """How often the way had to begin anew."""
    length: float
    """m."""
    resting: bool
    surroundings: Surroundings
    still: Reference
    """What was seen when it came to rest, or since, while much has changed."""
    still_since: float
    """When that was seen, s."""
    fitting: float
    """When a reading last fitted, s."""
    suspect: bool
    """Whether the last reading seemed to say that the sensor no longer rests."""
    lately: Annotated[Floats, Shape("h 4")]
    """(time, x, y, heading) of the last readings."""


class _Found(NamedTuple):
    """Where a reading was taken."""

    fit: Match
    resting: bool
    suspect: bool = False


def follow(
    way: Way | None,
    outline: Outline,
    time: float,
    parameters: EgoMotionParameters | None = None,
) -> Way:
    """The way with one more reading.

    Args:
        way: so far; None: this is the first reading, taken at rest at (0, 0, 0).
        outline: of the reading, in the robot's frame.
        time: when it was taken, s.
        parameters: thresholds.
    """
    p = parameters or EgoMotionParameters()
    if way is None:
        return _begun(outline, time, np.zeros(3))
    gap = time - way.time
    if gap < -p.gap:  # a part of its own for the clock, which whoever tracks people sees, too
        return replace(_anew(way, outline, time), part=way.part)
    if not gap > 0.0:
        return way
    found = _find(way, outline, gap, p)
    if found is not None:
        return _gone_on(way, outline, time, found, p)
    few = len(outline) < p.least
    if way.resting and (few or time - way.fitting <= p.patience):
        fitting = time if few else way.fitting
        return replace(way, time=time, matching=Matching.HELD, overlap=0.0, fitting=fitting)
    return _anew(way, outline, time)


def _anew(way: Way, outline: Outline, time: float) -> Way:
    begun = _begun(outline, time, way.pose)
    return replace(begun, matching=Matching.ANEW, overlap=0.0, part=way.part + 1, length=way.length)


def _begun(outline: Outline, time: float, pose: Floats) -> Way:
    """At rest, with nothing known of the past."""
    reference = reference_of(outline.placed(pose))
    return Way(
        time=time,
        pose=pose,
        twist=np.zeros(3),
        matching=Matching.OK,
        overlap=1.0,
        part=0,
        length=0.0,
        resting=True,
        surroundings=Surroundings(
            reference=reference, number=np.zeros(len(outline), dtype=np.int64), latest=0, X_MR=pose
        ),
        still=reference,
        still_since=time,
        fitting=time,
        suspect=False,
        lately=np.array([[time, *pose]]),
    )


def _find(way: Way, outline: Outline, gap: float, p: EgoMotionParameters) -> _Found | None:
    """Where the reading was taken; None: it fits nowhere."""
    if len(outline) < p.least:
        return None
    if way.resting:
        found = _at_rest(way, outline, p)
        if found is not None:
            return found
    least = p.overlap if gap <= p.gap else p.overlap_after_gap
    guess = _ahead(way, gap) if gap <= p.gap else way.pose
    reference = way.surroundings.reference
    fit = match(reference, outline, guess, p.noise)
    if fit.overlap < least:
        guess = search(reference, outline, guess, p.reach, p.turn)
        again = match(reference, outline, guess, p.noise)
        fit = again if again.overlap > fit.overlap else fit
    if fit.overlap < least:
        return None
    here = fit_at(reference, outline, way.pose, p.noise)
    if way.resting and not _moved(here, fit, p):  # much is hidden, and the rest is where it was
        return _Found(replace(fit, pose=way.pose), resting=True)
    return _Found(fit, resting=False)


def _at_rest(way: Way, outline: Outline, p: EgoMotionParameters) -> _Found | None:
    """The very pose at which the sensor rested; None: it has moved, or nobody can tell."""
    here = fit_at(way.still, outline, way.pose, p.noise)
    there = match(way.still, outline, way.pose, p.noise)
    if here.overlap < p.overlap:
        return None
    moved = _moved(here, there, p)
    if moved and (way.suspect or here.misfit - there.misfit > p.sure_gain):
        return None
    return _Found(replace(here, pose=way.pose, told=there.told), resting=True, suspect=moved)


def _moved(here: Match, there: Match, p: EgoMotionParameters) -> bool:
    """Whether having moved from here to there explains a reading clearly better."""
    away, turned = _apart(there.pose, here.pose)
    return (away > p.moved or turned > p.turned) and here.misfit - there.misfit > p.gain


def _gone_on(way: Way, outline: Outline, time: float, found: _Found, p: EgoMotionParameters) -> Way:
    pose, gap = found.fit.pose, time - way.time
    lately = np.vstack([way.lately[way.lately[:, 0] >= time - 2.0 * p.calm], [time, *pose]])
    resting = found.resting or _calm(lately, p)
    still, since, surroundings = way.still, way.still_since, way.surroundings
    changed = found.fit.overlap < p.changed and time - since >= p.refresh and not found.suspect
    if resting and (changed or not way.resting):
        still, since = reference_of(outline.placed(pose)), time
    if changed or not resting:
        surroundings = _kept(surroundings, outline, found.fit, p)
    twist = np.zeros(3) if resting else _twist(way.pose, pose, gap)
    return Way(
        time=time,
        pose=pose,
        twist=twist if gap <= p.gap else np.zeros(3),
        matching=Matching.OK if found.fit.told == 2 else Matching.PARTLY,
        overlap=found.fit.overlap,
        part=way.part,
        length=way.length + _apart(pose, way.pose)[0],
        resting=resting,
        surroundings=surroundings,
        still=still,
        still_since=since,
        fitting=time,
        suspect=found.suspect,
        lately=lately,
    )


def _calm(lately: Floats, p: EgoMotionParameters) -> bool:
    """Whether the last readings were all taken at one place."""
    since = lately[lately[:, 0] >= lately[-1, 0] - p.calm - 1e-6]
    if len(since) < 4 or lately[0, 0] > lately[-1, 0] - p.calm + 1e-6:
        return False
    turned = np.abs(wrap_angle(since[:, 3] - since[-1, 3]))
    away = np.hypot(*(since[:, 1:3] - since[-1, 1:3]).T)
    return bool((away <= 0.75 * p.moved).all() and (turned <= 0.75 * p.turned).all())


def _kept(
    known: Surroundings, outline: Outline, fit: Match, p: EgoMotionParameters
) -> Surroundings:
    """With what the reading saw first, if it was taken elsewhere than the last one that is kept."""
    off = _apart(fit.pose, known.X_MR)
    if off[0] < p.keyframe and off[1] < p.keyframe_turn and fit.overlap > 0.8:
        return known
    seen, before = outline.placed(fit.pose), known.reference.outline
    new = ~nearby(known.reference, seen, p.spacing)
    again = nearby(reference_of(seen), before, 2.0 * p.spacing)
    latest = known.latest + 1
    last_seen = np.where(again, latest, known.number)
    stays = last_seen > latest - p.kept
    points = np.concatenate([before.points[stays], seen.points[new]])
    normals = np.concatenate([before.normals[stays], seen.normals[new]])
    number = np.concatenate([last_seen[stays], np.full(int(new.sum()), latest)])
    reference, order = sorted_reference(Outline(points=points, normals=normals))
    return Surroundings(reference=reference, number=number[order], latest=latest, X_MR=fit.pose)


def _ahead(way: Way, gap: float) -> Floats:
    """Where the last motion leads."""
    dx, dy, turn = way.twist * gap
    half: Floats = compose([0.0, 0.0, 0.5 * turn], [dx, dy, 0.5 * turn])
    return compose(way.pose, half)


def _twist(before: Floats, now: Floats, gap: float) -> Floats:
    """The motion between two poses as that of a robot that turns evenly meanwhile."""
    change = compose(inverse(before), now)
    half: Floats = compose([0.0, 0.0, -0.5 * change[2]], [change[0], change[1], 0.0])
    return np.array([half[0], half[1], change[2]]) / gap


def _apart(a: Floats, b: Floats) -> tuple[float, float]:
    """(m, rad)."""
    return math.dist(a[:2], b[:2]), abs(float(wrap_angle(a[2] - b[2])))
