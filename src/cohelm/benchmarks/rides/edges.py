"""Edges of the floor: does a wheel ever go over one, and does the chair stop on safe floors?

Everything is drawn from the seed: height, angle, speed, distance. A person's hands do what leads
over the edge: steer for a place beyond it, push straight on, back up to it, or turn on the spot
beside it. The safe floors have ramps, thresholds, mats and floor that returns nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from cohelm.benchmarks.bench import BenchReport, Result, Sheet, chosen_names, unset
from cohelm.benchmarks.options import Settings, names
from cohelm.benchmarks.study import Grid, Study, Variant, axis, common
from cohelm.config import Model
from cohelm.evaluation import Outcome, Ride, run
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.geometry import transform
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.platforms.twin import load_mujoco
from cohelm.robots import Robot, load_robot
from cohelm.simulation import GroundTruth, generator
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.rider_input import deflected

TITLE = "Edges of the floor: falls, and stops where there is none"
ROBOT = "quantum_q6_edge_lidar"
PLATFORMS = ("planar", "twin")
MODES = ("stop_only", "assisted", "shared")
_TIME = (12, 30)
"""Duration of a ride at most, before an edge and on a safe floor, s."""
_STEEPEST = {"shaft": 30.0, "open ramp": 40.0}
"""Greatest angle to the normal of an edge that is short, degrees; else 80."""
_X, _Y = 8.0, 7.0
"""Middle of the hall's edge, m; the floor beyond it has greater x."""
COMPARED = {
    "robot": "the benchmark",
    "platform": "--platforms",
    "mode": "--modes",
    "rider": "--hands",
    **dict.fromkeys(("start", "goal", "storey", "profile.preferred_speed"), "the seed"),
}
"""Keys that cannot be set for all rides → what sets them."""


class Held:
    """A stick that is held in one direction from the first second on."""

    class Parameters(Model):
        """Deflection, share of full."""

        forward: float = 0.0
        left: float = 0.0

    needs_view = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        return deflected(view, (p.forward, p.left) if view.time > 1.0 else (0.0, 0.0))


_HELD = f"{__name__}:Held"
HANDS: Mapping[str, tuple[str, ...]] = {
    "steers beyond": ("rider.use=ideal",),
    "one switch": ("rider.use=one_switch",),
    "pushes on": (f"rider.use={_HELD}", "rider.forward=1.0"),
    "backs up": (f"rider.use={_HELD}", "rider.forward=-1.0"),
    "turns": (f"rider.use={_HELD}", "rider.left=0.8"),
}


def _beyond(height: float, rise: float = 0.0, steps: int = 0) -> list[dict[str, Any]]:
    """Floor of another height beyond the edge, and at the end of its rise on from there."""
    first = {"at": [_X + 1.5, _Y], "size": [3.0, 14.0], "height": height, "rise": rise}
    rest = {"at": [_X + 4.5, _Y], "size": [3.0, 14.0], "height": height + rise}
    return [{**first, "steps": steps}, rest]


def _kerb(rng: np.random.Generator) -> list[dict[str, Any]]:
    return _beyond(-_drawn(rng, 0.05, 0.2))


def _stairs(rng: np.random.Generator) -> list[dict[str, Any]]:
    return _beyond(0.0, -10 * _drawn(rng, 0.14, 0.18), 10)


def _platform(rng: np.random.Generator) -> list[dict[str, Any]]:
    return _beyond(-_drawn(rng, 0.3, 1.2))


def _shaft(rng: np.random.Generator) -> list[dict[str, Any]]:
    side = _drawn(rng, 1.4, 2.2)
    return [{"at": [_X + 0.5 * side, _Y], "size": [side, side], "height": -2.5}]


def _open_ramp(rng: np.random.Generator) -> list[dict[str, Any]]:
    """The way leads along a ramp of 1:20 whose side is open."""
    drop = _drawn(rng, 0.25, 0.5)
    ramp = {"at": [_X - 3.0, _Y], "size": [8.0, 6.0], "angle_deg": 90.0, "rise": -8.0 / 20.0}
    return [{"at": [_X + 3.0, _Y], "size": [6.0, 14.0], "height": -8.0 / 20.0 - drop}, ramp]


def _level(rng: np.random.Generator) -> list[dict[str, Any]]:
    return [{"at": [_X, _Y], "size": [0.5, 0.5], "height": 0.0}]


def _ramp(run: float, rng: np.random.Generator) -> list[dict[str, Any]]:
    return _beyond(0.0, float(rng.choice([-1.0, 1.0])) * 3.0 / run)


def _threshold(rng: np.random.Generator) -> list[dict[str, Any]]:
    bar = {"size": [_drawn(rng, 0.05, 0.25), 14.0], "height": _drawn(rng, 0.01, 0.02)}
    return [{"at": [_X + 0.1, _Y], **bar}]


def _mats(rng: np.random.Generator) -> list[dict[str, Any]]:
    xy = rng.uniform([_X - 1.5, _Y - 1.5], [_X + 2.0, _Y + 1.5], (4, 2))
    return [
        {"at": [round(x, 2), round(y, 2)], "size": [0.9, 0.6], "height": 0.01}
        for x, y in xy.tolist()
    ]


def _dark(rng: np.random.Generator) -> list[dict[str, Any]]:
    xy = rng.uniform([_X - 1.0, _Y - 2.0], [_X + 2.0, _Y + 2.0], (6, 2))
    return [
        {"at": [round(x, 2), round(y, 2)], "size": [0.4, 0.4], "dark": True} for x, y in xy.tolist()
    ]


EDGES: Mapping[str, Callable[[np.random.Generator], list[dict[str, Any]]]] = {
    "kerb": _kerb,
    "stairs": _stairs,
    "platform": _platform,
    "shaft": _shaft,
    "open ramp": _open_ramp,
}
SAFE: Mapping[str, Callable[[np.random.Generator], list[dict[str, Any]]]] = {
    "level": _level,
    "ramp 1:12": partial(_ramp, 12.0),
    "ramp 1:20": partial(_ramp, 20.0),
    "threshold": _threshold,
    "mats": _mats,
    "dark tiles": _dark,
}


def draw(kind: str, hand: str, robot: Robot, seed: int) -> tuple[str, ...]:
    """Draw floor, start and destination of a ride as settings of the scenario ``empty``."""
    rng = generator(seed, f"edges/{kind}/{hand}")
    levels = (EDGES.get(kind) or SAFE[kind])(rng)
    wide = 0.3 if kind == "shaft" else 1.0
    angle = math.radians(_drawn(rng, 0.0, _STEEPEST.get(kind, 80.0)))
    angle = math.copysign(angle, float(rng.choice([-1.0, 1.0])))
    ahead = np.array([math.cos(angle), math.sin(angle)])
    crossing = np.array([_X, _Y + _drawn(rng, -wide, wide)])
    away = _drawn(rng, 2.8, 4.0)
    heading, start = math.degrees(angle), crossing - away * ahead
    if hand == "backs up":
        heading += 180.0
    if hand == "turns":  # the farthest corner would swing over the edge
        reach = np.hypot(*robot.outline.T)
        start = np.array([_X - _drawn(rng, 0.62, 0.95) * float(reach.max()), crossing[1]])
        heading = _drawn(rng, 60.0, 120.0) * float(rng.choice([-1.0, 1.0]))
    values: dict[str, Any] = {
        "storey": {"levels": levels},
        "start": [*np.round(start, 3).tolist(), round(heading, 1)],
        "goal": np.round(crossing + 2.0 * ahead, 3).tolist(),
        "profile.preferred_speed": _drawn(rng, 0.4, 0.8),
    }
    return tuple(f"{key}={json.dumps(each)}" for key, each in values.items())


def _drawn(rng: np.random.Generator, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), 3)


class _Watch:
    """Distance of the wheels from the line of the edge, and what the chair said."""

    def __init__(self, robot: Robot) -> None:
        self.wheels, self.time = robot.wheels, 0.0
        self.stops = self.slow = 0
        self.over = -math.inf
        self._held = False

    def __call__(self, tick: Tick, truth: GroundTruth) -> None:
        self.time = truth.time
        self.over = max(self.over, float(transform(truth.pose, self.wheels)[:, 0].max()) - _X)
        held = tick.decision.reason is Reason.EDGE_AHEAD and not tick.decision.twist.any()
        self.stops += held and not self._held
        self.slow += tick.decision.reason is Reason.FLOOR_UNSEEN
        self._held = held

    def columns(self, ride: Ride) -> Mapping[str, Any]:
        """Columns of the row: the greatest x of a wheel beyond the edge, m; stops; seconds."""
        return {
            "over": self.over,
            "fell": ride.outcome is Outcome.FELL,
            "edge_stops": self.stops,
            "slow_share": self.slow / max(len(ride.pose), 1),
            "seconds": self.time,
        }


def create(
    kinds: Annotated[str | None, names(f"{', '.join((*EDGES, *SAFE))}; default: all.")] = None,
    hands: Annotated[str | None, names(f"{', '.join(HANDS)}; default: all.")] = None,
    modes: Annotated[str | None, names(f"Default: {', '.join(MODES)}.")] = None,
    platforms: Annotated[str | None, names("planar or twin; default: planar.")] = None,
    settings: Settings = (),
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        PlatformError: MuJoCo is asked for and not installed.
        ConfigError, ScenarioError: if a name or a setting does not exist.
    """
    unset(settings, COMPARED)
    floors = chosen_names(kinds, "--kinds", (*EDGES, *SAFE), kind="floor", known=(*EDGES, *SAFE))
    hand = chosen_names(hands, "--hands", HANDS, kind="hand", known=HANDS)
    where = chosen_names(platforms, "--platforms", PLATFORMS[:1], kind="platform", known=PLATFORMS)
    if "twin" in where:
        load_mujoco()
    robot = load_robot(ROBOT)
    drawn = tuple(
        Variant(
            columns=(("kind", kind), ("hand", each)),
            settings=(f"robot={ROBOT}", f"time_limit={_TIME[kind in SAFE]}", *HANDS[each]),
            scenario="empty",
            drawn=partial(draw, kind, each, robot),
        )
        for kind in floors
        for each in hand
    )
    driven = axis(
        "mode", {each: (f"mode={each}",) for each in chosen_names(modes, "--modes", MODES)}
    )
    both = axis("platform", {each: (f"platform.use={each}",) for each in where})
    grid = Grid((drawn, driven, both, common(settings)), compared=3)
    return Study(TITLE, grid, _report, _ride, SEEDS=10).checked()


def _ride(task: Sequence[RideTask]) -> list[Result]:
    out = []
    for each in task:
        watch = _Watch(load_robot(ROBOT))
        drive = partial(run, on_tick=watch)
        out.append(ride_row(each, empty_floor=False, more=watch.columns, drive=drive))
    return out


def _report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Falls by floor, by hand and by mode; stops an hour on safe floors."""
    rows = [result.row for result in results]
    edges = [row for row in rows if row["kind"] in EDGES]
    safe = [row for row in rows if row["kind"] in SAFE]
    sheets, notes = [], []
    summary: dict[str, Any] = {}
    if edges:
        lines = [
            _falls(name, [row for row in edges if row[column] == name])
            for column in ("kind", "hand", "mode", "platform")
            for name in dict.fromkeys(str(row[column]) for row in edges)
        ]
        head = ("", "approaches", "fell", "touched", "nearest wheel, m", "falls, seeds")
        sheets.append(Sheet("Approaches to an edge", head, tuple(lines)))
        fell = sum(row["outcome"] == "fell" for row in edges)
        summary |= {"approaches": len(edges), "fell": fell}
        verdict = "met" if fell == 0 else "MISSED"
        notes.append(f"no wheel over an edge: {verdict}; {fell} of {len(edges)} fell")
    if safe:
        head = ("floor", "rides", "reached", "hours", "stops at an edge", "time slowed")
        names = dict.fromkeys(str(row["kind"]) for row in safe)
        lines = [_stops(name, [row for row in safe if row["kind"] == name]) for name in names]
        sheets.append(Sheet("Safe floors", head, tuple(lines)))
        hours = sum(float(row.get("seconds") or 0.0) for row in safe) / 3600.0
        stops = sum(int(row.get("edge_stops") or 0) for row in safe)
        summary |= {"safe_hours": hours, "false_stops": stops}
        verdict = "met" if stops <= hours else "MISSED"
        notes.append(f"at most one false stop an hour: {verdict}; {stops} in {hours:.2f} h")
    return BenchReport(tuple(sheets), tuple(notes), summary)


def _falls(name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    fell = [row for row in rows if row["outcome"] == "fell"]
    seeds = ", ".join(dict.fromkeys(str(row["seed"]) for row in fell))
    beside = [row for row in rows if row not in fell and row["kind"] != "shaft"]
    near = [float(row["over"]) for row in beside if row.get("over") is not None]
    touched = sum(row["outcome"] == "collision" for row in rows)
    gap = f"{-max(near):.2f}" if near else "–"
    return name, f"{len(rows)}", f"{len(fell)}", f"{touched}", gap, seeds


def _stops(name: str, rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    seconds = sum(float(row.get("seconds") or 0.0) for row in rows)
    slow = sum(float(row.get("slow_share") or 0.0) for row in rows) / len(rows)
    reached = sum(row["outcome"] == "reached" for row in rows)
    stops = sum(int(row.get("edge_stops") or 0) for row in rows)
    return name, f"{len(rows)}", f"{reached}", f"{seconds / 3600.0:.2f}", f"{stops}", f"{slow:.0%}"
