"""Whether what is seen was there before: places that were empty a while ago and are not now.

What stands on legs and never moves is furniture; what stands where the scanner saw through before
has come there. Some scans of the past are kept, ever sparser with age, each with the pose that it
was taken from, so that a chair in motion may compare as well.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, SignedBytes, value
from cohelm.config import Model
from cohelm.geometry import compose
from cohelm.messages import Scan
from cohelm.perception.api import Detections
from cohelm.perception.clock import RAN_BACK

UNKNOWN, FULL, EMPTY, BLANK = 0, 1, 2, 3
"""What an earlier scan can say of a place: hidden or out of view, something there, seen through,
or that no beam came back from that direction at all."""


class NoveltyParameters(Model):
    """Of the comparison with the past; assumed where no reason is given."""

    youngest: float = Field(0.25, gt=0.0, le=5.0)
    """Age from which a scan is compared with, s: a leg that swings has left its place by then."""
    oldest: float = Field(300.0, gt=0.0, le=3600.0)
    """Age at which a scan is forgotten, s."""
    growth: float = Field(1.25, gt=1.0, le=10.0)
    """Ratio of the ages of scans that are kept, counted in scans: a pause costs no memory."""
    margin: float = Field(0.15, gt=0.0, le=1.0)
    """A return within this of an earlier one is the same thing, m."""
    margin_growth: float = Field(0.015, ge=0.0, le=0.2)
    """Growth of that with range, m/m (1° of localisation at most is 0.017)."""
    changed: float = Field(0.05, gt=0.0, le=1.0)
    """Share of the surroundings that may lie where nothing was; above it, it is the scanner that
    moved otherwise than its pose says, and the earlier scan tells nothing."""
    same: float = Field(0.85, gt=0.0, le=1.0)
    """Share that must lie where something was, in a scan just taken."""
    same_fading: float = Field(0.2, ge=0.0, le=5.0)
    """What that share may be less for each second of age, 1/s: who drives sees other things."""
    same_least: float = Field(0.2, ge=0.0, le=1.0)
    """The share that must lie there, however old the scan."""
    least: int = Field(2, ge=1, le=20)
    """Earlier scans that must have seen the place."""
    returns: int = Field(3, ge=1, le=20)
    """Returns that make something new: fewer may have slipped through between two beams."""
    blank: float = Field(0.35, ge=0.0, le=1.0)
    """What a beam that did not come back counts for, beside one that went through: dark and
    glossy things show now and then."""
    arriving: float = Field(1.5, gt=0.0, le=60.0)
    """Who came longer ago than this, s, has come to rest, which says neither."""
    settling: float = Field(5.0, gt=0.0, le=60.0)
    """What has been there for so long as could be seen is at rest, s."""
    came: float = Field(3.0, ge=0.0, le=10.0)
    """Log-odds of having moved, where the place was empty until lately."""
    adrift: float = Field(-2.0, ge=-10.0, le=0.0)
    """The same of everything while the scanner moves otherwise than its pose says: nothing that
    seems to walk does so for sure."""
    still: float = Field(-2.0, ge=-10.0, le=0.0)
    """The same where something was there as often as it could be seen."""


@value
class Glance:
    """A scan that is remembered."""

    scan: Scan
    X_MS: Annotated[Floats, Shape("3")]
    """Where its sensor was."""
    number: int
    """How many scans of that sensor came before it."""


Past = tuple[Glance, ...]
"""What is remembered, the newest first."""


def with_motion(
    seen: Detections, past: Past, parameters: NoveltyParameters | None = None
) -> Detections:
    """``seen`` with ``moved``: log-odds that each has come to where it is, 0 where not known.

    Looking back from the youngest scan, the time for which something was in the place is passed
    over; how empty the place was before says whether what is there now came then.
    """
    p = parameters or NoveltyParameters()
    d = len(seen.position)
    if not d or not past:
        return replace(seen, moved=np.zeros(d))
    owner = seen.owner
    width = np.concatenate([2.0 * seen.ellipse[:, 2], [0.0]])[seen.cluster]
    present, full, looks = np.zeros(d), np.zeros(d), np.zeros(d)
    here, trusted, doubted = None, 0, 0
    for glance in past:
        age = seen.time - glance.scan.time
        if not p.youngest <= age <= p.oldest:
            continue
        new, same, rest, share, known = _recalled(seen.points, width, owner, d, glance, p)
        if not _trusted(new, same, rest, age, p):
            doubted += age <= p.arriving
            continue
        trusted += age <= p.arriving
        if here is None:
            here = np.full(d, age <= p.arriving)
        here &= ~known | (share > 0.5)
        present[here & known] = age
        full += known * ~here * share
        looks += known & ~here
    if doubted > trusted:
        return replace(seen, moved=np.full(d, p.adrift))
    moved = _verdict(present, full, looks, p)
    thin = np.bincount(owner[owner >= 0], minlength=d) < p.returns
    return replace(seen, moved=np.where(thin, np.minimum(moved, 0.0), moved))


def _verdict(present: Floats, full: Floats, looks: Floats, p: NoveltyParameters) -> Floats:
    """Log-odds (d,) of having moved.

    Args:
        present: for how long there has been something in the place, s.
        full: how often it was full before.
        looks: how often it could be seen then.
        p: how to judge.
    """
    before = full / np.maximum(looks, 1.0)
    moved = np.interp(before, [0.15, 0.35, 0.5, 0.8], [p.came, 0.0, 0.0, p.still])
    moved = np.where((present > p.arriving) & (moved > 0.0), 0.0, moved)
    rests = p.still * np.clip(present / p.settling, 0.0, 1.0)
    seldom = np.where(looks > 0.0, np.minimum(moved, 0.0), rests)
    settled: Floats = np.where(looks >= p.least, moved, seldom)
    return settled


def remember(
    past: Past, scan: Scan, X_MR: Floats, parameters: NoveltyParameters | None = None
) -> Past:
    """``past`` with one more scan, taken with the robot at ``X_MR``, and as many fewer as will do.

    A clock that runs back ends the past; a scan or a pose that is not finite leaves it as it is.
    """
    p = parameters or NoveltyParameters()
    given = [scan.time, *X_MR, *scan.mount, scan.angle_min, scan.angle_increment]
    if not np.isfinite(given).all() or scan.angle_increment == 0.0 or not len(scan.ranges):
        return past
    if past and scan.time < past[0].scan.time - RAN_BACK:
        past = ()
    mount = scan.mount.tolist()
    others = [g for g in past if g.scan.mount.tolist() != mount]
    before = [g for g in past if g.scan.mount.tolist() == mount]
    number = before[0].number + 1 if before else 0
    kept = [Glance(scan=scan, X_MS=compose(X_MR, scan.mount), number=number)]
    for k, glance in enumerate(before):
        older = before[k + 1].number if k + 1 < len(before) else -math.inf
        since = max(number - kept[-1].number, 2)
        if p.growth**2 * since < number - older and scan.time - glance.scan.time <= p.oldest:
            kept.append(glance)
    return tuple(sorted((*kept, *others), key=lambda g: -g.scan.time))


_FEW = 20
"""So many returns that are nobody's must there be to tell whether the pose can be trusted."""


def _recalled(
    points: Floats, width: Floats, owner: Integers, d: int, glance: Glance, p: NoveltyParameters
) -> tuple[int, int, int, Floats, Booleans]:
    """See :func:`_places`, of an earlier scan."""
    scan = glance.scan
    beams = np.array([scan.angle_min, scan.angle_increment, scan.range_max])
    margin = np.array([p.margin, p.margin_growth])
    return _places(points, width, owner, d, scan.ranges, beams, glance.X_MS, margin, p.blank)


def _trusted(new: int, same: int, rest: int, age: float, p: NoveltyParameters) -> bool:
    """Whether the surroundings are where they were, as far as an earlier scan saw them."""
    if rest < _FEW:
        return True
    least = max(p.same - p.same_fading * age, p.same_least)
    return new <= p.changed * (new + same) and same >= least * rest


@njit(cache=True)
def _places(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    points: Floats,
    width: Floats,
    owner: Integers,
    d: int,
    ranges: Floats,
    beams: Floats,
    X_MS: Floats,
    margin: Floats,
    blank: float,
) -> tuple[int, int, int, Floats, Booleans]:
    """What an earlier scan says of all places: of the surroundings', and of each of d people's.

    Of the first, where nobody owns the points: how many are new, how many are the same, how many
    there are. Of each of the people: how full the place was (d,), 0…1, and whether that is known at
    all. The arguments are those of :func:`was_there`.
    """
    was = was_there(points, width, ranges, beams, X_MS, margin)
    new, same, rest = 0, 0, 0
    known, full = np.zeros(d), np.zeros(d)
    for i in range(len(was)):
        if owner[i] < 0:
            rest += 1
            new += was[i] == EMPTY
            same += was[i] == FULL
        elif was[i] != UNKNOWN:
            known[owner[i]] += blank if was[i] == BLANK else 1.0
            full[owner[i]] += was[i] == FULL
    return new, same, rest, full / np.maximum(known, 1e-9), known > 0.0


@njit(cache=True)
def was_there(
    points: Floats, width: Floats, ranges: Floats, beams: Floats, X_MS: Floats, margin: Floats
) -> SignedBytes:
    """What an earlier scan says of the places of points, as ``UNKNOWN`` to ``BLANK``.

    A place is full if something came back from within the margin. It was seen through if all of
    three beams about it end beyond the margin, as far as they come back, and if they lie so near
    each other that two at least would meet what stands there now. Else it was hidden, or out of
    view.

    Args:
        points: (p, 2), map frame, m.
        width: (p,) of the thing that each belongs to, m.
        ranges: (b,) of the earlier scan, m.
        beams: its first angle and its increment, rad, and its reach, m.
        X_MS: (3,) where it was taken.
        margin: m, and its growth with range, m/m.
    """
    b = ranges.shape[0]
    out = np.zeros(points.shape[0], dtype=np.int8)
    cos, sin, step = math.cos(X_MS[2]), math.sin(X_MS[2]), abs(beams[1])
    closed = (b + 1) * step >= 2.0 * math.pi
    for i in range(points.shape[0]):
        dx, dy = points[i, 0] - X_MS[0], points[i, 1] - X_MS[1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        away = math.hypot(x, y)
        near = margin[0] + margin[1] * away
        turned = math.atan2(y, x) - beams[0]
        turned = turned if beams[1] > 0.0 else -turned
        if not 0.0 <= turned < 2.0 * math.pi:  # the remainder is dear
            turned %= 2.0 * math.pi
        beam = turned / step
        middle = round(beam)
        if away < near:
            continue
        reach = min(int(near / (away * step)) + 1, b // 2)
        full, clear, lost, asked = False, away + near <= beams[2], 0, 0
        for turn in range(2 * reach + 1):  # outwards: what still stands is met at once
            k = middle + (-(turn // 2) if turn % 2 == 0 else (turn + 1) // 2)
            inside = 0 <= k < b
            if not (closed or inside):
                continue
            r = ranges[k if inside else k % b]
            returned = r > 0.0 and r <= beams[2]
            if returned:
                # the squared distance of the two, for a small angle between them
                across = (k - beam) * step
                full = (r - away) ** 2 + r * away * across * across <= near * near
                if full:
                    break
            if abs(k - middle) <= 1:
                asked += 1
                lost += not returned and not r > beams[2]
                clear = clear and (not returned or r > away + near)
        if full:
            out[i] = FULL
        elif clear and asked == 3 and 2.0 * away * step <= width[i]:
            out[i] = BLANK if lost == 3 else EMPTY
    return out
