"""What the CrowdNav cases say, beside what others reached in the very same ones."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.evaluation.benches.bench import Report, Sheet
from cohelm.recordings.outside import outside_file

Row = Mapping[str, Any]


class Line(NamedTuple):
    """One line of the table; NaN: not known."""

    name: str
    kinematics: str
    success: float
    collision: float
    time: float
    """Mean of the successes, s; so are the next two."""
    path: float = np.nan
    danger: float = np.nan
    """Share of steps with a gap below 0.2 m."""


REFERENCES = (
    Line("clairvoyant (knows the recorded future)", "holonomic", 1.0, 0.0, 8.71),
    Line("clairvoyant (knows the recorded future)", "unicycle", 1.0, 0.0, 8.48),
    Line("crude sampler, people keep on", "holonomic", 0.934, 0.066, 11.29),
    Line("crude sampler, people keep on", "unicycle", 0.528, 0.440, 10.70),
    Line("ORCA, radius + 0.20 m", "holonomic", 0.936, 0.050, 12.52, 9.58),
)
"""Measured on the same 500 cases, and told in docs/crowdnav.md."""
RECORDED = "crowdnav_measured_summary.json"
"""Beside the recording: references measured by CrowdNav's own code."""


class Wanted(NamedTuple):
    """What is asked of our own planner in the recorded cases."""

    success: float
    time: float
    collision: float = 0.005
    danger: float = 0.01


WANTED = {"holonomic": Wanted(0.998, 10.5), "unicycle": Wanted(0.99, 11.2)}
CASES = 500
"""That were recorded."""
_COLUMNS = ("", "robot", "success", "collision", "time, s", "path, m", "danger of successes")


def make_report(rows: Sequence[Row], planner: str, folder: Path, *, judged: bool) -> Report:
    """Tables, the curve over caution where there is one, and what was met or missed.

    Args:
        rows: of all cases.
        planner: that drove.
        folder: for the picture.
        judged: whether the wanted figures are about these cases.
    """
    cautions = sorted({float(row["caution"]) for row in rows})
    models = list(dict.fromkeys(str(row["kinematics"]) for row in rows))
    groups = {(c, m): _of(rows, c, m) for c in cautions for m in models}
    lines = {key: summed(each, planner, key[1]) for key, each in groups.items() if each}
    usual = 0.0 if 0.0 in cautions else cautions[0]
    main = [line for (c, _), line in lines.items() if c == usual]
    notes = [_speed(groups[usual, line.kinematics], line.kinematics) for line in main]
    if judged and usual == 0.0:
        notes += _few(groups[usual, line.kinematics] for line in main)
        notes += [note for line in main for note in _verdicts(line)]
    title = "successes and what they cost"
    wider = f", people {usual:+g} m wider" if usual else ""
    sheets = [Sheet(f"{title}{wider}", _COLUMNS, tuple(map(_cells, main)))]
    sheets.append(Sheet("others in the recorded cases", _COLUMNS, tuple(map(_cells, _others()))))
    files: tuple[Path, ...] = ()
    if len(cautions) > 1:
        curve = [
            (f"{c:g} m", *_cells(lines[c, m])[1:])
            for m in models
            for c in cautions
            if (c, m) in lines
        ]
        sheets.append(Sheet("wider people", ("added", *_COLUMNS[1:]), tuple(curve)))
        files = (_picture(lines, folder / "curve.png"),)
    summary = [{"caution": c, **line._asdict()} for (c, _), line in lines.items()]
    return Report(tuple(sheets), tuple(notes), {"lines": summary}, files)


def summed(rows: Sequence[Row], name: str, kinematics: str) -> Line:
    """Shares over all cases, means over the successes."""
    ends = [row["outcome"] for row in rows]
    won = [row for row in rows if row["outcome"] == "success"]
    steps = sum(row["steps"] for row in won)
    return Line(
        name=name,
        kinematics=kinematics,
        success=ends.count("success") / len(ends),
        collision=ends.count("collision") / len(ends),
        time=float(np.mean([row["time"] for row in won])) if won else np.nan,
        path=float(np.mean([row["path"] for row in won])) if won else np.nan,
        danger=sum(row["danger"] for row in won) / steps if steps else np.nan,
    )


def _of(rows: Sequence[Row], caution: float, model: str) -> list[Row]:
    return [row for row in rows if row["caution"] == caution and row["kinematics"] == model]


def _others() -> list[Line]:
    """The references measured by CrowdNav's own code where they are there, and the rest."""
    file = outside_file("crowdnav", RECORDED)
    measured = [] if file is None else json.loads(file.read_text(encoding="utf-8"))
    names = {"linear": "straight ahead", "orca": "ORCA"}
    found = [
        Line(
            names.get(each["policy"], each["policy"])
            + (f", radius + {each['safety']:.2f} m" if each["safety"] else ""),
            "holonomic",
            each["success"],
            each["collision"],
            each["nav_time"],
            each["path"],
            each["danger_freq"],
        )
        for each in measured
        if not each["visible"] and each["rule"] == "circle_crossing" and each["humans"] == 5
    ]
    return [*found, *REFERENCES]


def _cells(line: Line) -> tuple[str, ...]:
    figures = (f"{each:.{digits}f}" if np.isfinite(each) else "" for each, digits in
               zip(line[2:], (3, 3, 2, 2, 4), strict=True))  # fmt: skip
    return (line.name, line.kinematics, *figures)


def _speed(rows: Sequence[Row], model: str) -> str:
    middle = float(np.median([row["command_ms"] for row in rows]))
    worst = float(np.max([row["command_p99_ms"] for row in rows]))
    if not np.isfinite(middle):
        return f"{model}: no planner"
    return f"{model}: a command takes {middle:.1f} ms, p99 of the worst case {worst:.1f} ms"


def _few(groups: Iterable[Sequence[Row]]) -> list[str]:
    """What is asked is asked of all cases."""
    fewest = min((len(rows) for rows in groups), default=0)
    if fewest >= CASES:
        return []
    return [f"{fewest} of the {CASES} recorded cases: what follows is no finding"]


def _verdicts(line: Line) -> Iterator[str]:
    wanted = WANTED[line.kinematics]
    for what, figure, bound, met in (
        ("success", line.success, wanted.success, line.success >= wanted.success),
        ("mean time", line.time, wanted.time, line.time <= wanted.time),
        ("collisions", line.collision, wanted.collision, line.collision <= wanted.collision),
        ("danger", line.danger, wanted.danger, line.danger <= wanted.danger),
    ):
        word = "met" if met else "MISSED"
        yield f"{line.kinematics}: {what} {figure:.4g}, {bound:g} asked: {word}"


def _picture(lines: Mapping[tuple[float, str], Line], file: Path) -> Path:
    """Success over mean time, a point for each caution."""
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for k, model in enumerate(dict.fromkeys(model for _, model in lines)):
        own = [(c, line) for (c, m), line in lines.items() if m == model]
        axes.plot([line.time for _, line in own], [line.success for _, line in own], "o-",
                  label=model)  # fmt: skip
        for c, line in own:
            axes.annotate(f"{c:+.2f} m", (line.time, line.success), fontsize=7,
                          textcoords="offset points", xytext=(4, 6 - 16 * k))  # fmt: skip
    axes.set_xlabel("mean time of the successes, s")
    axes.set_ylabel("success")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(file, dpi=110)
    return file
