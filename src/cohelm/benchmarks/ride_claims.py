"""Claims on rides, as data: groups of rides are case → contender → rides.

A claim with a ``source`` is a statement of a publication, one without is a requirement of ours.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from typing import Protocol

import numpy as np

from cohelm.benchmarks.bench import known_name
from cohelm.benchmarks.claims import (
    AGREES,
    CONTRADICTS,
    ENOUGH,
    MET,
    MISSED,
    NOT_RUN,
    OURS,
    PARTLY,
    UNCLEAR,
    Bound,
    Verdict,
    bounded,
)
from cohelm.benchmarks.ride_figures import FIGURES
from cohelm.benchmarks.tables import estimate, measure, paired_differences, value_text
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import bootstrap_mean, median

Groups = Mapping[str, Mapping[str, Rides]]
"""Case → contender → rides."""


def few_rides(groups: Groups, kind: str = "ride") -> tuple[str, ...]:
    """Warning where some contender has fewer than ``ENOUGH`` rides in a case; else nothing."""
    fewest = min((len(each) for case in groups.values() for each in case.values()), default=0)
    if fewest >= ENOUGH:
        return ()
    noun = f"{fewest} {kind}{'' if fewest == 1 else 's'}"
    return (f"{noun} per case: too few, the verdicts are no findings",)


class Claim(Protocol):
    """A claim that can be judged on rides."""

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """Judge the claim; nothing where there are no rides to judge it by."""
        ...


@dataclass(frozen=True)
class Requirement:
    """Bound on a figure of one contender in some cases."""

    figure: str
    """Key of ``FIGURES``."""
    bound: Bound
    cases: tuple[str, ...] = ("*",)
    """Names or shell patterns."""
    contender: str = OURS
    source: str = ""
    text: str = ""
    """Statement of the source; it holds only where every case agrees."""
    pooled: str = ""
    """Name for the rides of all cases together; empty: one verdict per case."""
    only_missed: bool = False

    def __post_init__(self) -> None:
        """Check the figure.

        Raises:
            ConfigError: if there is none of this name.
        """
        known_name(self.figure, tuple(FIGURES), "figure", "Requirement")

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """See :class:`Claim`."""
        found = {case: groups[case][self.contender] for case in self._cases(groups)}
        found = {case: rides for case, rides in found.items() if len(rides)}
        if self.source:
            yield self._statement(found)
            return
        if self.pooled and found:
            found = {self.pooled: joined(found.values())}
        for case, rides in found.items():
            verdict = self._judge(case, rides)
            if verdict.result == MISSED or not self.only_missed:
                yield verdict

    def _cases(self, groups: Groups) -> list[str]:
        return [
            case
            for case, each in groups.items()
            if self.contender in each and any(fnmatch(case, pattern) for pattern in self.cases)
        ]

    def _judge(self, case: str, rides: Rides) -> Verdict:
        figure = FIGURES[self.figure]
        met = self.bound.holds(figure.value(rides))
        required = "" if self.bound == Bound() else self.bound.text(share=figure.share)
        result = (MET if met else MISSED) if required else ""
        remark = figure.worst(rides) if figure.worst and not met else ""
        arrived = int(rides.reached.sum())
        if self.figure == "time_ratio" and arrived < len(rides):
            remark = f"{arrived} of {len(rides)} rides arrived"
        subject = f"{case}, {self.contender}"
        return Verdict(subject, figure.label, figure.text(rides), required, result, remark)

    def _statement(self, found: Mapping[str, Rides]) -> Verdict:
        if not found:
            return not_run(self.source, self.text, [self.contender])
        figure = FIGURES[self.figure]
        holds = [self.bound.holds(figure.value(rides)) for rides in found.values()]
        complete = all(any(fnmatch(case, each) for case in found) for each in self.cases)
        agrees = AGREES if complete else PARTLY
        says = ", ".join(f"{case} {figure.text(rides)}" for case, rides in found.items())
        result = agrees if all(holds) else CONTRADICTS
        return Verdict(self.source, self.text, f"{figure.label}: {says}", result=result)


Place = tuple[str, str]
"""Case and contender."""
Pair = tuple[Place, Place]


@dataclass(frozen=True)
class Ordering:
    """Statement that measures are larger (or smaller) in one place than in another, per pair.

    It agrees where the 95 % interval of every mean paired difference lies on the claimed side, and
    contradicts where one lies on the other side.
    """

    text: str
    measures: tuple[str, ...]
    sign: int
    """1: larger, −1: smaller."""
    pairs: tuple[Pair, ...]
    source: str

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """See :class:`Claim`."""
        sides, says, missing = [], [], []
        for one, other in self.pairs:
            mine, theirs = (groups.get(case, {}).get(who) for case, who in (one, other))
            if mine is None or theirs is None:
                absent = ((mine, one), (theirs, other))
                missing += [who for rides, (_, who) in absent if rides is None]
                continue
            for name in self.measures:
                side, text = self._compare(name, (one, mine), (other, theirs))
                sides.append(side)
                says.append(text)
        missing = list(dict.fromkeys(missing))
        if not sides:
            yield not_run(self.source, self.text, missing)
            return
        remark = f"not run: {', '.join(missing)}" if missing else ""
        result = _ordered(min(sides), whole=not missing)
        yield Verdict(self.source, self.text, "; ".join(says), result=result, remark=remark)

    def _compare(
        self, name: str, one: tuple[Place, Rides], other: tuple[Place, Rides]
    ) -> tuple[int, str]:
        """Side of the difference (1: as claimed, 0: not clear, −1: opposite), and the medians."""
        difference = bootstrap_mean(paired_differences(one[1], other[1], name))
        clear = difference.count > 1 and not difference.low <= 0.0 <= difference.high
        names = self._names(one[0], other[0])
        texts = [
            f"{where} {value_text(estimate(rides, name).mean, name)}"
            for where, (_, rides) in zip(names, (one, other), strict=True)
        ]
        side = self.sign * int(np.sign(difference.mean)) if clear else 0
        label = f"{measure(name).label}: " if len(self.measures) > 1 else ""
        return side, f"{label}{texts[0]}, {texts[1]}{'' if clear else ' (not apart)'}"

    def _names(self, one: Place, other: Place) -> tuple[str, str]:
        """Names of both places, the shared part once."""
        if one[0] == other[0]:
            return ", ".join(filter(None, one)), other[1]
        return ", ".join(one), other[0]


def _ordered(side: int, *, whole: bool) -> str:
    if side < 0:
        return CONTRADICTS
    if side == 0:
        return UNCLEAR
    return AGREES if whole else PARTLY


def within(
    cases: Sequence[str], one: str, others: Sequence[str]
) -> tuple[tuple[Place, Place], ...]:
    """Pairs of one contender with each of some others, case by case."""
    return tuple(((case, one), (case, other)) for case in cases for other in others)


def between(contender: str, cases: Sequence[str], reference: str) -> tuple[Pair, ...]:
    """Pairs of each of some cases with a reference case, for one contender."""
    return tuple(((case, contender), (reference, contender)) for case in cases)


@dataclass(frozen=True)
class FewestOf:
    """Requirement that no rival has a smaller share than ours; if strict, only 0 may be equal."""

    figure: str
    cases: tuple[str, ...]
    rivals: Callable[[str], bool]
    pooled: str = ""
    strict: bool = False

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """See :class:`Claim`."""
        for case, by_planner in pooled(groups, self.cases, self.pooled).items():
            values = {name: FIGURES[self.figure].value(r) for name, r in by_planner.items()}
            mine = values.pop(OURS)
            rivals = {name: value for name, value in values.items() if self.rivals(name)}
            if not rivals:
                continue
            least = min(rivals.values())
            best = [name for name, value in rivals.items() if value == least]
            met = mine <= least if not self.strict else mine < least or mine == least == 0.0
            found = f"{100.0 * mine:.1f} %; best of the others {100.0 * least:.1f} %"
            claim = f"{FIGURES[self.figure].label}, against others"
            required = "fewest" if self.strict else "no more than the others"
            yield Verdict(
                f"{case}, {OURS}", claim, found, required, MET if met else MISSED, ", ".join(best)
            )


@dataclass(frozen=True)
class NearFastest:
    """Bound on our time beside that of the fastest of the rivals with the fewest collisions."""

    bound: Bound
    cases: tuple[str, ...]
    rivals: Callable[[str], bool]
    pooled: str = ""

    def verdicts(self, groups: Groups) -> Iterator[Verdict]:
        """See :class:`Claim`."""
        matching = [
            groups[case] for case in groups if any(fnmatch(case, pattern) for pattern in self.cases)
        ]
        for case, by_planner in pooled(groups, self.cases, self.pooled).items():
            rivals = {name: each for name, each in by_planner.items() if self.rivals(name)}
            if not rivals:
                continue
            hits = {name: float(each.any_collision.mean()) for name, each in rivals.items()}
            safest = [name for name in rivals if hits[name] == min(hits.values())]
            ratios = {name: self._slower(matching, name) for name in safest}
            fastest = max(ratios, key=lambda name: np.nan_to_num(ratios[name], nan=-np.inf))
            claim = f"median time over that of {fastest}, the fastest of the safest"
            yield bounded(f"{case}, {OURS}", claim, ratios[fastest], self.bound,
                          f"{ratios[fastest]:.2f}")  # fmt: skip

    @staticmethod
    def _slower(groups: Iterable[Mapping[str, Rides]], name: str) -> float:
        """Median of our time over the rival's, on seeds on which both arrive."""
        ratios = []
        for each in groups:
            if OURS in each and name in each:
                i, j = each[OURS].pairs(each[name])
                ratios.append(each[OURS].column("time")[i] / each[name].column("time")[j])
        return median(np.concatenate(ratios))


def pooled(groups: Groups, cases: Sequence[str], name: str) -> dict[str, dict[str, Rides]]:
    """Matching cases with rides of ours; with a name, joined over what all of them have."""
    found = {
        case: dict(each)
        for case, each in groups.items()
        if OURS in each and any(fnmatch(case, pattern) for pattern in cases)
    }
    if not name or not found:
        return found
    names = [who for who in next(iter(found.values())) if all(who in e for e in found.values())]
    return {name: {who: joined(e[who] for e in found.values()) for who in names}}


def joined(groups: Iterable[Rides]) -> Rides:
    """Rides of several groups together."""
    each = list(groups)
    return Rides([row for rides in each for row in rides], each[0].by)


def judge(claims: Iterable[Claim], groups: Groups) -> list[Verdict]:
    """Judge all claims."""
    return list(itertools.chain.from_iterable(claim.verdicts(groups) for claim in claims))


def not_run(source: str, text: str, contenders: Iterable[str]) -> Verdict:
    """Verdict on a statement that lacks rides."""
    return Verdict(source, text, f"needs rides of {', '.join(contenders)}", result=NOT_RUN)
