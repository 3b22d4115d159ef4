"""How sure a difference on equal seeds is: intervals and tests of paired rides."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from cohelm.arrays import Floats, value
from cohelm.evaluation.bootstrap import Estimate, mean_of
from cohelm.evaluation.results.measures import Measure

ALPHA = 0.05
"""A difference with a smaller p-value, corrected for how many were tested, is called one."""
_EXACT = 50


@value
class Contrast:
    """A measure of some rides less that of others on the same cases and seeds."""

    less: Estimate
    """Mean of the differences, with its 95 % bootstrap interval."""
    p: float
    """Two-sided; NaN where there is nothing to test."""
    corrected: float = float("nan")
    """p, corrected for all that were tested beside it (Holm 1979)."""
    better: int = 0
    """1: more is better, −1: less, 0: neither."""
    leans: int = 0
    """The side that the test speaks for: 1 more of it, −1 less, 0 neither."""

    @property
    def verdict(self) -> str:
        """``better``, ``worse``, ``differs``, or nothing where it may well be chance.

        The mean may lie on the other side than most pairs, of which the test speaks: such a
        measure differs, and neither is better.
        """
        if not self.corrected < ALPHA:
            return ""
        if not self.better or self.less.mean * self.leans <= 0.0:
            return "differs"
        return "better" if self.leans * self.better > 0 else "worse"


def contrast(
    ours: Floats, theirs: Floats, how: Measure, units: Sequence[Hashable] | None = None
) -> Contrast:
    """``ours`` less ``theirs``, (k,) each, pair by pair; pairs that lack one are left out.

    Shares are tested by McNemar's exact test (1947), all else, and means of shares, by Wilcoxon's
    signed ranks (1945).

    Args:
        ours: of one.
        theirs: of the other.
        how: what the measure means.
        units: of each pair; pairs of one unit are no independent ones, and count as one with the
            mean of their differences. None: each counts.
    """
    both = np.isfinite(ours) & np.isfinite(theirs)  # inf: nobody was ever near
    less = ours[both] - theirs[both]
    if units is not None:
        less = _by_unit(less, [unit for unit, pair in zip(units, both, strict=True) if pair])
    is_yes_or_no = how.share and bool(np.isin(less, (-1.0, 0.0, 1.0)).all())
    test = exact_mcnemar if is_yes_or_no else signed_ranks
    return Contrast(less=mean_of(less), p=test(less), better=how.better, leans=_side(less))


def _by_unit(less: Floats, units: Sequence[Hashable]) -> Floats:
    """Differences (k,) as one mean for each unit, in the order in which they come."""
    found: dict[Hashable, list[float]] = {}
    for unit, each in zip(units, less, strict=True):
        found.setdefault(unit, []).append(float(each))
    return np.array([float(np.mean(each)) for each in found.values()])


def _side(less: Floats) -> int:
    """On which side of 0 the differences (k,) lie by their signed ranks: 1, −1, or 0 on neither."""
    moved = less[less != 0.0]
    ranks = stats.rankdata(np.abs(moved))
    return int(np.sign((np.sign(moved) * ranks).sum()))


def exact_mcnemar(less: Floats) -> float:
    """Two-sided p of differences (k,) of yes and no: are +1 and −1 equally likely? NaN for none."""
    if not len(less):
        return float("nan")
    up, down = int((less > 0.0).sum()), int((less < 0.0).sum())
    return 1.0 if up + down == 0 else float(stats.binomtest(up, up + down).pvalue)


def signed_ranks(less: Floats) -> float:
    """Two-sided p of differences (k,): are they symmetric about 0? NaN for none.

    Wilcoxon's signed ranks, pairs without a difference left out. Up to 50 others the distribution
    of the rank sum is exact, ties and all; beyond, the normal approximation is taken.
    """
    if not len(less):
        return float("nan")
    moved = less[less != 0.0]
    if not len(moved):
        return 1.0
    if len(moved) > _EXACT:
        return float(stats.wilcoxon(moved, method="asymptotic").pvalue)
    # Mid-ranks are halves, so twice the ranks are whole numbers: each is added or it is not.
    ranks = np.rint(2.0 * stats.rankdata(np.abs(moved))).astype(int)
    chance = np.zeros(int(ranks.sum()) + 1)
    chance[0] = 1.0
    for rank in ranks:
        chance[rank:] = 0.5 * (chance[rank:] + chance[: len(chance) - rank])
        chance[:rank] *= 0.5
    least = int(min(ranks[moved > 0.0].sum(), ranks[moved < 0.0].sum()))
    return min(1.0, 2.0 * float(chance[: least + 1].sum()))


def corrected(contrasts: Sequence[Contrast]) -> list[Contrast]:
    """The same with p-values corrected for how many they are (Holm 1979)."""
    given = np.array([each.p for each in contrasts], dtype=float)
    holm = holm_corrected(given)
    return [replace(each, corrected=float(p)) for each, p in zip(contrasts, holm, strict=True)]


def holm_corrected(p: Floats) -> Floats:
    """p-values (k,) corrected by Holm's step-down procedure (1979); NaN are no tests."""
    out = np.full(len(p), np.nan)
    there = np.flatnonzero(np.isfinite(p))
    order = there[np.argsort(p[there], kind="stable")]
    steps = np.arange(len(order), 0, -1) * p[order]
    out[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return out
