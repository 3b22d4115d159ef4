"""Drawings of a report: box plots of the measures, tracks, and curves over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup

from cohelm.arrays import Floats
from cohelm.errors import CohelmError
from cohelm.evaluation.metrics.measures import measure_info
from cohelm.evaluation.report.rides import Key, Rides
from cohelm.evaluation.report.summary import case_name
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.plotting import panels
from cohelm.scenarios.build import RideSetup, build_scenario

CASES = 6
"""Largest number of cases that are drawn; tables and files have all."""
BOXED = ("time", "time_ratio", "min_distance", "path_length")
"""Measures with box plots."""
GAP = 6
"""Column of the gap to the nearest person in a curve."""
CURVES: Mapping[str, tuple[int, float | None]] = {
    "speed, m/s": (4, None),
    "turn rate, rad/s": (5, None),
    "nearest person, m": (GAP, 6.0),
}
"""Curves over time (Xu et al., Figs 14b, d, f): column, and upper limit of the axis."""

Say = Callable[[str], None]
Styles = Mapping[str, panels.Look]


@dataclass(frozen=True)
class ReportFigure:
    """SVG or image of a report."""

    content: Markup
    caption: str = ""
    is_map: bool = False


@dataclass(frozen=True)
class Drawings:
    """All drawings of a report."""

    styles: Sequence[tuple[str, Markup]]
    """Contender and a sample of its line and mark."""
    selection: str
    seeds: str
    boxes: list[list[ReportFigure]] = field(default_factory=list)
    tracks: list[ReportFigure] = field(default_factory=list)
    curves: list[ReportFigure] = field(default_factory=list)


def draw(rides: Rides, base: str, say: Say) -> Drawings:
    """Draw box plots, tracks and curves of all contenders."""
    styles = {name: panels.look(i) for i, name in enumerate(rides.contenders)}
    split = rides.split()
    cases = evenly(list(split), CASES)
    some = "" if len(cases) == len(split) else f"{len(cases)} of the {len(split)} cases are drawn."
    out = Drawings(
        styles=[(name, Markup(panels.sample(each))) for name, each in styles.items()],
        selection=some,
        seeds=f"{some} In each case the seed on which {base} took its median time.".strip(),
    )
    say(f"drawing {len(cases)} of {len(split)} cases")
    if len(split) > 1:
        out.boxes.append(_boxes("all cases", rides.by_contender(), styles))
    for case in cases:
        name = case_name(case, rides.by) or "all rides"
        out.boxes.append(_boxes(name, split[case], styles))
        shown = typical(split[case], base)
        if shown:
            seed = next(iter(shown.values())).seeds[0]
            out.tracks.append(_tracks(f"{name}, seed {seed}", shown, styles))
            out.curves.extend(_curves(f"{name}, seed {seed}", shown, styles))
    return out


def evenly(cases: Sequence[Key], most: int) -> list[Key]:
    """At most ``most`` cases, evenly spaced, with the first and the last one."""
    if len(cases) <= most:
        return list(cases)
    return [cases[i] for i in np.linspace(0, len(cases) - 1, most).astype(int)]


def typical(by_name: Mapping[str, Rides], base: str) -> dict[str, Rides]:
    """Contender → its ride, with a curve, on the seed of the baseline's median time.

    The seed is one of those that most contenders rode; the others are left out.
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


def _setup_of(ride: Rides) -> RideSetup | None:
    """Setup of the first ride; None where its row does not define it."""
    task = RideTask.from_row(ride.rows[0])
    try:
        return None if task is None else build_scenario(task.load(), task.seed)
    except (CohelmError, OSError):
        return None


def _boxes(title: str, by_name: Mapping[str, Rides], styles: Styles) -> list[ReportFigure]:
    figures = []
    for key in BOXED:
        if not any(each.has(key) for each in by_name.values()):
            continue
        values = {
            name: panels.Values(styles[name], each.column(key), each.column("reached") == 0.0)
            for name, each in by_name.items()
        }
        figures.append(_svg(panels.box_panel(title, measure_info(key).heading, values)))
    return figures


def _tracks(title: str, shown: Mapping[str, Rides], styles: Styles) -> ReportFigure:
    curves = {name: (styles[name], curve_of(each)[:, :3]) for name, each in shown.items()}
    setup = _setup_of(next(iter(shown.values())))
    if setup is None:
        return _svg(panels.track_panel(title, curves, None, np.full((2, 2), np.nan)), is_map=True)
    ends = np.array([setup.start[:2], setup.request.goal])
    return _svg(panels.track_panel(title, curves, setup.world.grid, ends), is_map=True)


def _curves(title: str, shown: Mapping[str, Rides], styles: Styles) -> list[ReportFigure]:
    out = []
    for axis, (column, top) in CURVES.items():
        lines = {
            name: (styles[name], curve_of(each)[:, 0], curve_of(each)[:, column])
            for name, each in shown.items()
        }
        if any(np.isfinite(values).any() for _, _, values in lines.values()):
            out.append(_svg(panels.curve_panel(title, axis, lines, top)))
    return out


def curve_of(one: Rides) -> Floats:
    """Curve of one ride, with gaps clipped at 0 as in the measures."""
    if one.curves[0] is None:
        return np.empty((0, 8))
    curve = one.curves[0].copy()
    curve[:, GAP] = curve[:, GAP].clip(min=0.0)
    return curve


def _svg(svg: str, *, is_map: bool = False) -> ReportFigure:
    return ReportFigure(Markup(svg), is_map=is_map)  # drawn here, with escaped text
