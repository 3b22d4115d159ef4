"""What Xu et al. conclude from Table 3, claim by claim, and whether our rides say the same."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

from cohelm.arrays import Floats
from cohelm.evaluation.benches.paper_table3 import COLUMNS, Column, median, values_of
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.bootstrap import mean_of
from cohelm.evaluation.results.rides import Rides

Groups = Mapping[str, Mapping[str, Rides]]
"""Scene → planner → rides."""

AGREES, OPPOSES, UNCLEAR, UNKNOWN = "agrees", "does not agree", "no clear difference", "not ridden"
PARTLY = "agrees as far as it was ridden"
"""Where a scene or a planner that the claim speaks of is missing."""
ALL = ("crossing", "aggressive", "distracted")

_GAP, _TIME, _LENGTH, _VAR_V, _VAR_W = COLUMNS


@dataclass(frozen=True)
class Finding:
    """What our rides say of a claim."""

    verdict: str
    evidence: str


class Judge(Protocol):
    """Who looks at the rides."""

    def __call__(self, groups: Groups) -> Finding:
        """Whether they say what is claimed."""
        ...


@dataclass(frozen=True)
class Ordering:
    """One planner has less, or more, of a measure than each of some others, on the same seeds.

    It agrees where the 95 % interval of every mean paired difference lies on the claimed side, and
    does not where one lies on the other side.
    """

    one: str
    others: tuple[str, ...]
    column: Column
    scenes: tuple[str, ...]
    sign: int
    """1: more of it, −1: less."""

    def __call__(self, groups: Groups) -> Finding:
        """See :class:`Judge`."""
        sides, says, whole = [], [], True
        for scene in self.scenes:
            by_planner = groups.get(scene, {})
            mine = by_planner.get(self.one)
            rivals = [name for name in self.others if name in by_planner]
            whole &= mine is not None and len(rivals) == len(self.others)
            if mine is None or not rivals:
                continue
            says.append(f"{scene} {_median(mine, self.column)} {self.one}")
            for name in rivals:
                side = _side(_less(mine, by_planner[name], self.column)) * self.sign
                sides.append(side)
                text = f"{_median(by_planner[name], self.column)} {name}"
                says.append(text if side else f"{text} (not apart)")
        wanting = _wanting(groups, (self.one, *self.others), self.scenes)
        if not sides:
            return _not_ridden(wanting or (self.one, *self.others))
        says += [f"{name} not ridden" for name in wanting]
        return Finding(_verdict(sides, whole=whole), f"{self.column.head}: {', '.join(says)}")


@dataclass(frozen=True)
class Touching:
    """A planner touches people in every one of some scenes, or in none."""

    planner: str
    scenes: tuple[str, ...]
    touches: bool

    def __call__(self, groups: Groups) -> Finding:
        """See :class:`Judge`."""
        found = {
            scene: groups[scene][self.planner]
            for scene in self.scenes
            if self.planner in groups.get(scene, {})
        }
        if not found:
            return _not_ridden((self.planner,))
        as_said = [bool(group.hit_moving.any()) == self.touches for group in found.values()]
        agrees = AGREES if len(found) == len(self.scenes) else PARTLY
        verdict = agrees if all(as_said) else OPPOSES
        says = [f"{s}: {int(g.hit_moving.sum())} of {len(g)}" for s, g in found.items()]
        return Finding(verdict, f"rides with a collision: {', '.join(says)}")


@dataclass(frozen=True)
class Rougher:
    """A planner has more of a measure in some scenes than in another."""

    planner: str
    columns: tuple[Column, ...]
    scenes: tuple[str, ...]
    than: str

    def __call__(self, groups: Groups) -> Finding:
        """See :class:`Judge`."""
        other = groups.get(self.than, {}).get(self.planner)
        sides, says = [], []
        if other is None or _wanting(groups, (self.planner,), self.scenes):
            return _not_ridden((self.planner,))
        for column in self.columns:
            says.append(f"{column.title}: {self.than} {_median(other, column)}")
            for scene in self.scenes:
                mine = groups.get(scene, {}).get(self.planner)
                if mine is not None:
                    sides.append(_side(_less(mine, other, column)))
                    says.append(f"{scene} {_median(mine, column)}")
        whole = all(self.planner in groups.get(scene, {}) for scene in self.scenes)
        return Finding(_verdict(sides, whole=whole), ", ".join(says))


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper in our words."""

    says: str
    judge: Judge


_RIVALS = ("mpc", "mpc_dcbf", "social_mpc")
_UNHURT = ("mpc_dcbf", "social_mpc")

CLAIMS = (
    Claim("SS-MPC-DCBF drives the shortest way in all three scenes",
          Ordering(OURS, _RIVALS, _LENGTH, ALL, -1)),
    Claim("SS-MPC-DCBF's speed varies less than that of both others that avoid people",
          Ordering(OURS, _UNHURT, _VAR_V, ALL, -1)),
    Claim("SS-MPC-DCBF's turning varies less than that of both others that avoid people",
          Ordering(OURS, _UNHURT, _VAR_W, ALL, -1)),
    Claim("SS-MPC-DCBF avoids everybody in all three scenes", Touching(OURS, ALL, touches=False)),
    Claim("MPC, which does not predict, hits people in all three scenes",
          Touching("mpc", ALL, touches=True)),
    Claim("MPC-DCBF avoids everybody in all three scenes",
          Touching("mpc_dcbf", ALL, touches=False)),
    Claim("MPC-DCBF, which knows no social space, passes nearer than SS-MPC-DCBF who is aggressive "
          "or distracted", Ordering("mpc_dcbf", (OURS,), _GAP, ("aggressive", "distracted"), -1)),
    Claim("Socially-aware MPC keeps the largest distance in crossing",
          Ordering("social_mpc", ("mpc", "mpc_dcbf", OURS), _GAP, ("crossing",), 1)),
    Claim("Socially-aware MPC hits who is aggressive",
          Touching("social_mpc", ("aggressive",), touches=True)),
    Claim("Socially-aware MPC drives less smoothly in crossing and aggressive than in distracted",
          Rougher("social_mpc", (_VAR_V, _VAR_W), ("crossing", "aggressive"), "distracted")),
    Claim("MPC-DCBF is the fastest in crossing and aggressive",
          Ordering("mpc_dcbf", ("mpc", "social_mpc", OURS), _TIME, ("crossing", "aggressive"), -1)),
    Claim("SS-MPC-DCBF is the fastest in distracted",
          Ordering(OURS, _RIVALS, _TIME, ("distracted",), -1)),
    Claim("MPC is the slowest in all three scenes",
          Ordering("mpc", ("mpc_dcbf", "social_mpc", OURS), _TIME, ALL, 1)),
)  # fmt: skip
"""All that Table 3 and the sentences about it order."""


def judged(groups: Groups) -> Iterator[tuple[Claim, Finding]]:
    """Each claim with what the rides say of it."""
    for claim in CLAIMS:
        yield claim, claim.judge(groups)


def in_words(claim: Claim, finding: Finding) -> str:
    """A sentence: the claim, whether it is so here, and the figures."""
    return f"the paper: {claim.says}. Here: {finding.verdict}; {finding.evidence}"


def _wanting(groups: Groups, planners: tuple[str, ...], scenes: tuple[str, ...]) -> list[str]:
    """Planners without a ride in any of the scenes."""
    return [name for name in planners if not any(name in groups.get(s, {}) for s in scenes)]


def _not_ridden(planners: Iterable[str]) -> Finding:
    return Finding(UNKNOWN, f"it takes rides of {', '.join(planners)}")


def _less(one: Rides, other: Rides, column: Column) -> Floats:
    """One's values less the other's, on the seeds that both rode; NaN where one did not arrive."""
    i, j = one.pairs(other)
    return values_of(one, column)[i] - values_of(other, column)[j]


def _side(less: Floats) -> int:
    """The sign of a mean that is clearly on one side of 0, else 0."""
    found = mean_of(less)
    if found.count < 2 or found.low <= 0.0 <= found.high:
        return 0
    return 1 if found.mean > 0.0 else -1


def _verdict(sides: list[int], *, whole: bool) -> str:
    if min(sides) < 0:
        return OPPOSES
    if min(sides) == 0:
        return UNCLEAR
    return AGREES if whole else PARTLY


def _median(group: Rides, column: Column) -> str:
    found = median(group, column)
    return f"{found.mean:.{column.digits}f}" if found.count else "–"
