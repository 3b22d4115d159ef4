"""Compare the behaviour of two versions of cohelm bit for bit.

A refactoring must not change one ride. This script records rides, plans, detections and CrowdNav
cases with the code that it lies beside, and compares two such recordings::

    python benchmarks/behaviour.py record OUT             # about 20 minutes on two cores
    python benchmarks/behaviour.py compare OUT_A OUT_B
    python benchmarks/behaviour.py compare REV_A REV_B    # sets up both revisions and records them

Names may change between versions, so every revision carries its own copy of this script, and a
case keeps its key. ``renamed_reasons.txt`` beside this script lists renamed reason codes; further
ones are given as ``--renamed old=new``. Cases on outside data need ``COHELM_DATA`` (default
``../shared/data``); a case that cannot run is an error.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

Arrays = Mapping[str, Any]
"""Result of one case: arrays by name; numbers are compared bit for bit."""

HOSPITAL, REAL_MAP = "hospital", "ros_maps/utexas_gdc_3ne.yaml"
RIDES: dict[str, tuple[str, int, dict[str, Any]]] = {
    # key: (scenario, seed, settings); the key stays when a name changes
    **{
        f"hospital/{mode}/{seed}": (HOSPITAL, seed, {"mode": mode})
        for seed, mode in ((0, "autonomous"), (1, "shared"), (3, "shared"), (4, "autonomous"))
    },
    "hospital/nudge": (HOSPITAL, 2, {"mode": "shared", "rider.use": "nudge"}),
    "hospital/unseeing": (HOSPITAL, 5, {"mode": "autonomous", "people.see_robot": False}),
    "hospital/upf": (HOSPITAL, 6, {"mode": "autonomous", "global_planner.use": "upf"}),
    "hospital/tremor": (HOSPITAL, 8, {"mode": "assisted", "rider.use": "tremor"}),
    "hospital/social_force": (HOSPITAL, 9, {"people.model.use": "social_force"}),
    **{
        f"crossing/{planner}": ("crossing", seed, {"local_planner.use": planner})
        for seed, planner in enumerate(
            ("ss_mpc_dcbf", "path_follower", "dwa", "teb", "mpc", "mpc_dcbf", "social_mpc", "apf")
        )
    },
    "crossing/ideal": ("crossing", 11, {"mode": "shared", "rider.use": "ideal"}),
    "crossing/manual": ("crossing", 12, {"mode": "manual", "rider.use": "ideal"}),
    **{f"aggressive/{seed}": ("aggressive", seed, {}) for seed in (0, 21)},
    **{f"distracted/{seed}": ("distracted", seed, {}) for seed in (0, 22)},
    "corridor-1/autonomous": ("corridor-1", 0, {}),
    "corridor-1/assisted": ("corridor-1", 1, {"mode": "assisted", "rider.use": "ideal"}),
    "corridor-2/autonomous": ("corridor-2", 0, {}),
    "corridor-2/shared": ("corridor-2", 1, {"mode": "shared", "rider.use": "biased"}),
    "corridor-3/autonomous": ("corridor-3", 0, {}),
    "corridor-3/manual": ("corridor-3", 1, {"mode": "manual", "rider.use": "watchful"}),
    "corridor-4/autonomous": ("corridor-4", 0, {}),
    "corridor-4/one_switch": ("corridor-4", 1, {"mode": "shared", "rider.use": "one_switch"}),
    "lidar": ("lidar", 0, {}),
    "talking": ("talking", 0, {}),
    "frontal": ("frontal", 0, {}),
    "intersection": ("intersection", 1, {}),
    "narrow-doorway": ("narrow-doorway", 0, {}),
    "blind-spot": ("blind-spot", 0, {}),
    "door": ("door", 0, {}),
    "real-map": (
        HOSPITAL,
        0,
        {"map": REAL_MAP, "start": (-51.68, -11.42), "goal": (-36.78, -7.82), "people.count": 4},
    ),
}
"""Modes, riders, planners, predictors and pedestrians; every local planner at least once."""

PLANS: dict[str, tuple[str, str, dict[str, Any]]] = {
    # key: (floor or map, global planner, start, goal and wishes)
    f"plan/{k}/{method}": (HOSPITAL, method, wish)
    for k, (method, wish) in enumerate(
        [
            ("astar", {}),
            ("upf", {"prefer": [[20.0, 8.0]]}),
            ("upf_soft", {"prefer": [[20.0, 8.0]]}),
            ("soft_via", {"prefer": [[20.0, 8.0]]}),
            ("soft_via", {"avoid": [{"points": [[15.0, 9.0]], "radius": 1.5}]}),
            ("soft_via", {"stroke": [[8.0, 9.0], [20.0, 8.0], [30.0, 9.0]]}),
            ("iterative_astar", {"prefer": [[20.0, 8.0]]}),
            ("soft_via", {"prefer": [[12.0, 9.0], [30.0, 9.0]]}),
            ("upf_soft", {"prefer": [[12.0, 9.0], [30.0, 9.0]]}),
            ("soft_via", {}),
        ]
    )
}
RECORDINGS = (
    "lidar/legtracker_demo_stationary_simple.bag",
    "lidar/legtracker_positive_3_extracted.bag",
    "lidar/kitti_obj_000000.bin",
)
FRAMES = 400
"""Maximum number of frames of each recording."""
CROWDNAV_CASES = 20
RENAMED_REASONS = Path(__file__).with_name("renamed_reasons.txt")
"""Reason codes, ``old=new`` on each line."""


def main() -> int:
    """Record, or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("record", help="record every case with this version")
    one.add_argument("out", type=Path)
    one.add_argument("--only", default="", help="only cases whose key contains this")
    one.add_argument("--workers", type=int, default=2)
    two = commands.add_parser("compare", help="compare two recordings, or two git revisions")
    two.add_argument("a")
    two.add_argument("b")
    two.add_argument("--renamed", action="append", default=[], metavar="OLD=NEW")
    args = parser.parse_args()
    if args.command == "record":
        return record(args.out, args.only, args.workers)
    folders = [_recorded(each) for each in (args.a, args.b)]
    renamed = [*RENAMED_REASONS.read_text(encoding="utf-8").split(), *args.renamed]
    return compare(*folders, dict(each.split("=", 1) for each in renamed))


# --- recording ---------------------------------------------------------------------------------


def record(out: Path, only: str, workers: int) -> int:
    """Run the cases whose key contains ``only``; a case that is recorded already is kept."""
    out.mkdir(parents=True, exist_ok=True)
    keys = [key for key in cases() if only in key and not _file(out, key).exists()]
    failed, began = [], time.monotonic()
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        running = {pool.submit(run_case, key, out): key for key in keys}
        for done, future in enumerate(as_completed(running), 1):
            key, error = running[future], future.exception()
            if error is not None:
                failed.append(key)
            note = f"FAILED: {error!r}" if error else future.result()
            print(
                f"{done}/{len(keys)} {time.monotonic() - began:6.0f} s  {key}: {note}", flush=True
            )
    return 1 if failed else 0


def cases() -> dict[str, Callable[[str], Arrays]]:
    """Key of every case → the function that runs it."""
    recordings = [f"recording/{Path(name).stem}" for name in RECORDINGS]
    return {
        **dict.fromkeys((f"ride/{key}" for key in RIDES), ride),
        **dict.fromkeys(PLANS, plan),
        **dict.fromkeys(recordings, recording),
        **{f"crowdnav/{model}": crowdnav for model in ("holonomic", "unicycle")},
    }


def run_case(key: str, out: Path) -> str:
    """Run one case and store what it left behind."""
    arrays = cases()[key](key)
    file = _file(out, key)
    np.savez(file.with_suffix(".part.npz"), **arrays)
    file.with_suffix(".part.npz").rename(file)
    return str(arrays.get("outcome", "done"))


def ride(key: str) -> Arrays:
    """One ride: every pose, command and reason."""
    from cohelm.evaluation import run
    from cohelm.scenarios import load_scenario

    name, seed, given = RIDES[key.removeprefix("ride/")]
    given = dict(given)
    changes: dict[str, Any] = {}
    if "map" in given:
        nothing = ("floor", "prefer", "obstacles", "doors", "filters")
        changes = {"map": str(data(given.pop("map"))), **dict.fromkeys(nothing)}
        changes |= {name: list(given.pop(name)) for name in ("start", "goal")}
    settings = [f"{name}={_yaml(value)}" for name, value in given.items()]
    reasons, etas = [], []

    def watch(tick: Any, truth: Any) -> None:
        reasons.append("" if tick.decision.reason is None else tick.decision.reason.value)
        etas.append(0.0 if tick.authority is None else tick.authority.eta)

    result = run(load_scenario(name, settings, changes), seed, watch)
    return {
        "outcome": result.outcome.value,
        "time": result.time,
        "pose": result.pose,
        "twist": result.twist,
        "command": result.command,
        "eta": np.array(etas),
        "people": result.people,
        "reason": np.array(reasons),
    }


def plan(key: str) -> Arrays:
    """One route across the hospital floor."""
    from cohelm.scenarios import build_scenario, load_scenario

    floor, method, wish = PLANS[key]
    changes = {"prefer": None, **wish, "global_planner": {"use": method}}
    path = build_scenario(load_scenario(floor, ["people.count=0"], changes), 0).route
    return {"points": path.points, "cost": path.cost, "length": path.length}


def recording(key: str) -> Arrays:
    """People found in every frame of a recording."""
    from itertools import islice

    from cohelm.evaluation import perceive_frames, perception_of
    from cohelm.recordings import open_recording

    (name,) = (each for each in RECORDINGS if Path(each).stem == key.removeprefix("recording/"))
    people, times = [], []
    source = open_recording(data(name))
    still = source.frames == 1
    for seen in perceive_frames(islice(source, FRAMES), perception_of(), still=still, at_rest=True):
        found = seen.perceived.people
        times.append(seen.observation.time)
        member = seen.perceived.groups.member
        rows = np.column_stack([np.full(len(found), len(times)), found.id, member, found.mean])
        people.append(rows)
    return {"time": np.array(times), "people": np.concatenate(people)}


def crowdnav(key: str) -> Arrays:
    """CrowdNav's first recorded cases."""
    from cohelm.benchmarks.external.crowdnav import create
    from cohelm.evaluation.external.crowdnav import run

    model = key.removeprefix("crowdnav/")
    bench = create(kinematics=model)
    outcomes = [
        run(bench._people(case), bench._driver(0.0, model), model) for case in range(CROWDNAV_CASES)
    ]
    return {
        "outcome": " ".join(each.end for each in outcomes),
        "poses": np.concatenate([each.poses for each in outcomes]),
        "steps": np.array([each.steps for each in outcomes]),
    }


def data(name: str) -> Path:
    """A file of the outside data.

    Raises:
        FileNotFoundError: if it is not there.
    """
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    file = Path(os.environ.get("COHELM_DATA") or default).absolute() / name
    if not file.exists():
        raise FileNotFoundError(f"{file} (set COHELM_DATA)")
    return file


def _yaml(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _file(out: Path, key: str) -> Path:
    return out / f"{key.replace('/', '__')}.npz"


# --- comparing ---------------------------------------------------------------------------------


def compare(a: Path, b: Path, renamed: Mapping[str, str]) -> int:
    """Print every difference; 0 where there is none.

    Args:
        a, b: folders of two recordings.
        renamed: reason codes of ``a`` → those of ``b``.
    """
    names = sorted({file.name for each in (a, b) for file in each.glob("*.npz")})
    if not names:
        print(f"nothing is recorded in {a} and {b}", file=sys.stderr)
        return 2
    different = 0
    for name in names:
        problem = _difference(a / name, b / name, renamed)
        different += bool(problem)
        if problem:
            print(f"{name.removesuffix('.npz').replace('__', '/')}: {problem}")
    print(f"{len(names)} cases: {len(names) - different} equal, {different} different")
    return 1 if different else 0


def _difference(a: Path, b: Path, renamed: Mapping[str, str]) -> str:
    for file in (a, b):
        if not file.exists():
            return f"not recorded in {file.parent}"
    with np.load(a) as one, np.load(b) as two:
        if set(one.files) != set(two.files):
            return f"records {sorted(one.files)} and {sorted(two.files)}"
        return next(filter(None, (_field(k, one[k], two[k], renamed) for k in one.files)), "")


def _field(name: str, one: Any, two: Any, renamed: Mapping[str, str]) -> str:
    if one.dtype.kind == "U":
        one = np.vectorize(lambda code: renamed.get(code, code), otypes=[object])(one).astype(str)
    if one.shape != two.shape:
        return f"{name} has shape {one.shape} and {two.shape}"
    numbers = one.dtype.kind == "f"
    same = (one == two) | (np.isnan(one) & np.isnan(two)) if numbers else one == two
    if np.all(same):
        return ""
    first = tuple(int(k) for k in np.argwhere(~np.atleast_1d(same))[0])
    at = first if one.ndim else ()
    return f"{name} first differs at {first}: {one[at]!r} and {two[at]!r}"


def _recorded(name: str) -> Path:
    """A folder of recordings; a git revision is set up and recorded first."""
    if Path(name).is_dir():
        return Path(name)
    root = Path(__file__).resolve().parents[1]
    revision = subprocess.check_output(
        ["git", "-C", str(root), "rev-parse", "--verify", f"{name}^{{commit}}"], text=True
    ).strip()
    tree = Path(tempfile.gettempdir()) / f"cohelm-behaviour-{revision[:12]}"
    if not tree.exists():
        _call("git", "-C", str(root), "worktree", "add", "--detach", str(tree), revision)
    os.environ.setdefault("COHELM_DATA", str(data("")))
    _call("make", "-C", str(tree), "setup")
    python = tree / ".venv" / "bin" / "python"
    _call(str(python), str(tree / "benchmarks" / "behaviour.py"), "record", str(tree / "out"))
    return tree / "out"


def _call(*command: str) -> None:
    subprocess.run(command, check=True)


if __name__ == "__main__":
    sys.exit(main())
