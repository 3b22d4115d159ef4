"""The tables of a report: groups beside each other, each less the base, and the paper's row."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from cohelm.evaluation.bootstrap import Estimate, mean_of
from cohelm.evaluation.results.contrasts import Contrast
from cohelm.evaluation.results.markup import Content, Markup, table, tag
from cohelm.evaluation.results.measures import PROXIES, Measure, measure
from cohelm.evaluation.results.rides import Key, Rides
from cohelm.evaluation.results.summary import centre, contrasts


@dataclass(frozen=True)
class PaperTable:
    """What a paper says of the same cases."""

    says: str
    """Which paper and table: ``Xu et al., Table 3``."""
    rows: Mapping[Key, Mapping[str, float]]
    """Values of all ``by`` columns → measure by our name → their number."""


def case_tables(
    title: str,
    by_name: Mapping[str, Rides],
    base: str,
    shown: Sequence[str],
    theirs: Mapping[str, Mapping[str, float]] = MappingProxyType({}),
    source: str = "",
) -> Markup:
    """Of one case: the groups, and how they differ from the base.

    Args:
        title: above them.
        by_name: contender → rides.
        base: that the others are compared with.
        shown: measures; those that no ride has are left out.
        theirs: contender → measure → a paper's number.
        source: which paper.
    """
    names = [
        key
        for key in shown
        if any(each.has(key) for each in by_name.values()) or any(key in r for r in theirs.values())
    ]
    return tag(
        "div",
        tag("h3", title),
        _groups(by_name, names, theirs, source),
        differences(by_name, base, names),
    )


def _groups(
    by_name: Mapping[str, Rides],
    names: Sequence[str],
    theirs: Mapping[str, Mapping[str, float]],
    source: str,
) -> Markup:
    rows: list[list[Content]] = []
    for name, group in by_name.items():
        cells = [_estimate(centre(group, key, measure(key)), measure(key)) for key in names]
        rows.append([name, str(len(group)), *cells])
        if name in theirs:
            rows.append(_theirs(name, theirs[name], names))
    rows += [_theirs(name, row, names) for name, row in theirs.items() if name not in by_name]
    caption = "share of rides [95 % score interval] or median [95 % bootstrap interval]"
    if theirs:
        caption += f"; in italics: {source}"
    some = next(iter(by_name.values()))
    return table([some.by[-1], "rides", *_heads(names)], rows, caption)


def _theirs(name: str, row: Mapping[str, float], names: Sequence[str]) -> list[Content]:
    cells = [_number(row.get(key, math.nan), measure(key)) for key in names]
    return [tag("i", f"{name}, paper"), "", *(tag("i", cell) for cell in cells)]


def differences(by_name: Mapping[str, Rides], base: str, names: Sequence[str]) -> Markup:
    """Every other group less the base on equal seeds; empty where there is nobody to compare."""
    less = contrasts(by_name, base, names)
    others = [name for name in by_name if name != base]
    if not less or not others:
        return Markup("")
    rows: list[list[Content]] = []
    for name in others:
        pairs = len(by_name[name].pairs(by_name[base])[0])
        cells = [_contrast(less[name, key], measure(key)) for key in names]
        rows.append([name, str(pairs), *cells])
    caption = (
        f"less {base} on equal seeds: mean [95 % bootstrap interval], p by signed ranks "
        "(of shares: McNemar), corrected after Holm for all rows of a column"
    )
    if by_name[base].has_alike:
        caption += "; the riders of one scene and seed count as one, with their mean"
    some = next(iter(by_name.values()))
    return table([some.by[-1], "pairs", *_heads(names)], rows, caption)


def proxies(rides: Rides) -> Markup:
    """What stands in for a rider's opinion, over all cases; empty where nobody held a stick."""
    names = [name for name in PROXIES if rides.has(name)]
    if not any(name != "authority" for name in names):  # without a device it is 0
        return Markup("")
    rows: list[list[Content]] = []
    for name in rides.contenders:
        group = rides.of(contender=name)
        cells = [_estimate(centre(group, key, measure(key)), measure(key)) for key in names]
        rows.append([name, str(len(group)), *cells])
    return table([rides.by[-1], "rides", *_heads(names)], rows, "median [95 % interval], all cases")


def ratings(rides: Rides) -> Markup:
    """What people who rode said, from 1 to 5; empty where nobody was asked."""
    if not rides.has("rating"):
        return Markup("")
    rows: list[list[Content]] = []
    for name in rides.contenders:
        given = rides.of(contender=name).column("rating")
        given = given[np.isfinite(given)]
        if len(given):
            mean = mean_of(given)
            rows.append([name, str(len(given)), _estimate(mean, Measure("rating"))])
    return table([rides.by[-1], "rides rated", "mean [95 % interval]"], rows)


def _heads(names: Sequence[str]) -> list[Content]:
    arrows = {1: "\N{NO-BREAK SPACE}↑", -1: "\N{NO-BREAK SPACE}↓", 0: ""}
    return [measure(name).label + arrows[measure(name).better] for name in names]


def _estimate(each: Estimate, how: Measure) -> Content:
    if not each.count:
        return "–"
    interval = f"[{_number(each.low, how)}, {_number(each.high, how)}]"
    return [_number(each.mean, how), tag("small", interval)]


def _contrast(each: Contrast, how: Measure) -> Content:
    if not each.less.count:
        return "–"
    kind = {"better": "good", "worse": "bad"}.get(each.verdict)
    sign = "+" if each.less.mean > 0.0 else ""
    interval = f"[{_number(each.less.low, how)}, {_number(each.less.high, how)}]"
    p = "" if math.isnan(each.corrected) else tag("small", f"p {as_p(each.corrected)}")
    return [
        tag("span", f"{sign}{_number(each.less.mean, how)} {each.verdict}".strip(), class_=kind),
        tag("small", interval),
        p,
    ]


def as_p(p: float) -> str:
    """``< .001``, ``= .03``."""
    return "< .001" if p < 0.001 else f"= {p:.2g}".replace("0.", ".")


def _number(x: float, how: Measure) -> str:
    if not math.isfinite(x):
        return "–"
    text = f"{100.0 * x if how.share else x:.{how.digits}f}"
    return text if float(text) else text.removeprefix("-")
