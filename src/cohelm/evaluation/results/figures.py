"""The drawn parts of a report: boxes of the measures, tracks, and curves over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import CohelmError
from cohelm.evaluation.results.again import task_of
from cohelm.evaluation.results.markup import Markup, tag
from cohelm.evaluation.results.measures import measure
from cohelm.evaluation.results.page import section
from cohelm.evaluation.results.rides import Key, Rides
from cohelm.evaluation.results.summary import case_name
from cohelm.evaluation.staging import Stage, set_stage
from cohelm.pictures import panels

CASES = 6
"""That are drawn each by itself at most; tables and files have them all."""
BOXED = ("time", "time_ratio", "min_distance", "path_length")
"""Measures with box plots, where rides say something of them."""
GAP = 6
CURVES: Mapping[str, tuple[int, float | None]] = {
    "speed, m/s": (4, None),
    "turn rate, rad/s": (5, None),
    "gap to the nearest person, m": (GAP, 6.0),
}
"""What is drawn over time (Xu et al., Figs 14b, d, f): column of the curve, and where it is cut."""

Say = Callable[[str], None]


def drawn(rides: Rides, base: str, say: Say) -> Markup:
    """Boxes, tracks and curves of all contenders."""
    looks = {name: panels.look(i) for i, name in enumerate(rides.contenders)}
    split = rides.split()
    cases = some_of(list(split), CASES)
    few = "" if len(cases) == len(split) else f"{len(cases)} of the {len(split)} cases are drawn. "
    key = legend(looks)
    say(f"drawing {len(cases)} of {len(split)} cases")
    boxes = [_boxes("all cases", rides.together(), looks)] if len(split) > 1 else []
    tracks, curves = [], []
    for case in cases:
        name = case_name(case, rides.by) or "all rides"
        boxes.append(_boxes(name, split[case], looks))
        shown = typical(split[case], base)
        if shown:
            seed = next(iter(shown.values())).seeds[0]
            tracks.append(_tracks(f"{name}, seed {seed}", shown, looks))
            curves += _curves(f"{name}, seed {seed}", shown, looks)
    seeds = f"{few}Of each case the seed on which {base} took its median time, for all alike."
    return Markup(
        section("boxes", "Ride by ride", _soft(f"{few}{_BOXES}"), key, boxes)
        + section(
            "tracks", "Where they went", *_if(tracks, _soft(f"{seeds} A mark each 2 s."), key),
            tag("div", tracks, class_="panels") if tracks else "",
        )
        + section(
            "curves", "How they went", *_if(curves, _soft(seeds), key),
            tag("div", curves, class_="panels") if curves else "",
        )
    )  # fmt: skip


_BOXES = (
    "A dot is a ride, a cross one that did not reach its goal; the box holds the middle half, "
    "the bar is the median, whiskers go to the last ride within 1.5 boxes."
)


def legend(looks: Mapping[str, panels.Look]) -> Markup:
    """Contender → its line and mark."""
    items = [tag("li", Markup(panels.sample(each)), name) for name, each in looks.items()]
    return tag("ul", items, class_="legend")


def some_of(cases: Sequence[Key], most: int) -> list[Key]:
    """At most so many of them, evenly spread, the first and the last among them."""
    if len(cases) <= most:
        return list(cases)
    return [cases[i] for i in np.linspace(0, len(cases) - 1, most).astype(int)]


def typical(by_name: Mapping[str, Rides], base: str) -> dict[str, Rides]:
    """Contender → its ride, with a curve, on the seed on which the base took its median time.

    Of the seeds that most contenders rode; contenders that did not are left out.
    """
    with_curve = {
        name: {row["seed"]: i for i, row in enumerate(each.rows) if each.curves[i] is not None}
        for name, each in by_name.items()
    }
    count: dict[int, int] = {}
    for seeds in with_curve.values():
        for seed in seeds:
            count[seed] = count.get(seed, 0) + 1
    if not count:
        return {}
    fullest = max(count.values())
    lead = base if with_curve.get(base) else max(with_curve, key=lambda n: len(with_curve[n]))
    time = by_name[lead].column("time")
    at = [(s, time[i]) for s, i in with_curve[lead].items() if count[s] == fullest]
    at = at or [(seed, np.nan) for seed, n in count.items() if n == fullest]
    ordered = sorted(at, key=lambda each: (np.isnan(each[1]), each[1], each[0]))
    there = sum(bool(np.isfinite(each[1])) for each in ordered)
    seed = ordered[(there - 1) // 2 if there else 0][0]
    return {
        name: by_name[name].take([seeds[seed]])
        for name, seeds in with_curve.items()
        if seed in seeds
    }


def stage_of(ride: Rides) -> Stage | None:
    """Where the first of them was ridden; None where nobody can say."""
    task = task_of(ride.rows[0])
    try:
        return None if task is None else set_stage(task.load(), task.seed)
    except (CohelmError, OSError):
        return None


def _boxes(title: str, by_name: Mapping[str, Rides], looks: Mapping[str, panels.Look]) -> Markup:
    figures = []
    for key in BOXED:
        if not any(each.has(key) for each in by_name.values()):
            continue
        values = {
            name: panels.Values(looks[name], each.column(key), each.column("reached") == 0.0)
            for name, each in by_name.items()
        }
        figures.append(_figure(panels.box_panel(title, measure(key).label, values)))
    return tag("div", figures, class_="panels large") if figures else Markup("")


def _tracks(title: str, shown: Mapping[str, Rides], looks: Mapping[str, panels.Look]) -> Markup:
    curves = {name: (looks[name], _curve(each)[:, :3]) for name, each in shown.items()}
    stage = stage_of(next(iter(shown.values())))
    if stage is None:
        svg = panels.track_panel(title, curves, None, np.full((2, 2), np.nan))
    else:
        ends = np.array([stage.start[:2], stage.request.goal])
        svg = panels.track_panel(title, curves, stage.world.grid, ends)
    return _figure(svg, class_="map")


def _curves(
    title: str, shown: Mapping[str, Rides], looks: Mapping[str, panels.Look]
) -> list[Markup]:
    out = []
    for axis, (column, top) in CURVES.items():
        lines = {
            name: (looks[name], _curve(each)[:, 0], _curve(each)[:, column])
            for name, each in shown.items()
        }
        if any(np.isfinite(values).any() for _, _, values in lines.values()):
            out.append(_figure(panels.curve_panel(title, axis, lines, top)))
    return out


def _curve(one: Rides) -> Floats:
    """Its curve; the gap clipped at 0, as in the measures: who overlaps is touched."""
    if one.curves[0] is None:
        return np.empty((0, 8))
    curve = one.curves[0].copy()
    curve[:, GAP] = curve[:, GAP].clip(min=0.0)
    return curve


def _figure(svg: str, class_: str | None = None) -> Markup:
    return tag("figure", Markup(svg), class_=class_)


def _soft(words: str) -> Markup:
    return tag("p", words, class_="soft")


def _if(there: Sequence[Markup], *content: Markup) -> tuple[Markup, ...]:
    return content if there else ()
