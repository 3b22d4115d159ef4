"""Search parameters of every local planner, with one budget, one cost and the same rides.

    python benchmarks/tune.py [--planners ss_mpc_dcbf,dwa] [--draws 60] [--workers 2]

The searched parameters are declared in ``benchmarks/tuned/spaces.yaml``, the method and the cost in
``cohelm.benchmarks.tuning``: collisions, failures, time, standing, intimate distances and jerk.
Seeds start at 1000; results are ridden on lower ones.

For each planner it writes to ``benchmarks/tuned/`` all rides (``.csv``) and all draws with their
costs, versions and seeds (``.json``), and the best draw to ``src/cohelm/scenarios/tuned/`` where
``cohelm bench rides --tuned`` finds it. After Ctrl-C the next call continues, unless the code has
changed.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import multiprocessing
import signal
import sys
import time
from collections.abc import Iterable
from importlib.metadata import version
from multiprocessing.pool import Pool
from pathlib import Path
from typing import Any

import yaml

import cohelm
from cohelm.benchmarks.tuning import (
    CYCLE,
    DRAWS,
    FIRST_SEED,
    PARTS,
    RUNGS,
    Axis,
    Training,
    check_known,
    draws,
    read_spaces,
    survivors,
)
from cohelm.errors import CohelmError
from cohelm.scenarios.presets import nested, tuned_file

FOLDER = Path(__file__).parent / "tuned"
COLUMNS = ("key", "draw", "ride", "scene", "seed", "outcome", "cost", *PARTS, "error")
NO_PART_OF_RIDES = ("cli", "live", "plotting", "recordings", "testing", "tuned", "web")
"""Folders of the package whose code does not affect rides."""
PARTS_THAT_COUNT = ("cohelm", "numpy", "scipy", "numba", "daqp")


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--planners", help="comma-separated; default: all with a space")
    arguments.add_argument("--draws", type=int, default=DRAWS)
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--out", type=Path, default=FOLDER, help="folder of rides and draws")
    arguments.add_argument("--keep", action="store_true", help="do not write the best draws")
    given = arguments.parse_args()
    if min(given.draws, given.workers) < 1:
        arguments.error("--draws and --workers are at least 1")
    try:
        spaces = read_spaces(FOLDER / "spaces.yaml")
        planners = list(spaces) if given.planners is None else given.planners.split(",")
        check_known(spaces, planners)
    except CohelmError as cause:
        arguments.error(str(cause))
    given.out.mkdir(parents=True, exist_ok=True)
    context = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork
    clock = Clock(len(planners) * rides_of(given.draws))
    with context.Pool(given.workers, initializer=_ignore_interrupt) as pool:
        for planner in planners:
            search = Search(planner, spaces[planner], given.draws, given.out)
            whole = search.go(pool, clock)
            best = search.write(whole=whole)
            if whole and not given.keep:
                write_best(planner, best, given.draws)
            if not whole:
                sys.exit(130)


def rides_of(count: int) -> int:
    """Number of rides of a search with a number of draws."""
    had, total = 0, 0
    for share, rides in RUNGS:
        total += -(-count // share) * (rides - had)
        had = rides
    return total


class Clock:
    """Prints progress and remaining time.

    Args:
        total: rides.
    """

    def __init__(self, total: int) -> None:
        self.total, self.done, self.ridden, self.began = total, 0, 0, time.monotonic()

    def __call__(self, what: str, *, known: int = 0, ridden: int = 0) -> None:
        """Count rides known from an earlier call, and new ones."""
        self.done += known + ridden
        self.ridden += ridden
        pace = (time.monotonic() - self.began) / max(self.ridden, 1)
        left = f", {pace * (self.total - self.done) / 60.0:.0f} min left" if self.ridden else ""
        print(f"\r{what}: {self.done} of {self.total} rides{left}   ", end="", flush=True)


class Search:
    """Search for one planner; rides are appended to a file.

    Args:
        planner: its name.
        axes: searched parameters.
        count: number of draws.
        folder: of the files.
    """

    def __init__(self, planner: str, axes: dict[str, Axis], count: int, folder: Path) -> None:
        self.planner, self.axes, self.folder = planner, axes, folder
        self.draws = draws(axes, count)
        self.code = code_digest()
        self.rides: dict[tuple[int, int], dict[str, Any]] = {}

    def go(self, pool: Pool, clock: Clock) -> bool:
        """Ride until all rungs are done; False if it was interrupted."""
        known = self._known()
        left = list(range(len(self.draws)))
        try:
            for rung, (_, upto) in enumerate(RUNGS):
                if rung:
                    left = survivors(
                        {draw: self.costs(draw) for draw in left}, rung, len(self.draws)
                    )
                wanted = [(d, i) for d in left for i in range(upto) if (d, i) not in self.rides]
                there = [each for each in wanted if self._key(*each) in known]
                for each in there:
                    self.rides[each] = known[self._key(*each)]
                what = f"{self.planner}, rung {rung + 1}"
                clock(what, known=len(there))
                todo = [each for each in wanted if each not in self.rides]
                for draw, index, row in pool.imap_unordered(_ride, self._tasks(todo)):
                    self._keep(draw, index, row)
                    clock(what, ridden=1)
        except KeyboardInterrupt:
            return False
        return True

    def costs(self, draw: int) -> list[float]:
        """Costs of a draw's rides, in their order."""
        mine = sorted(index for d, index in self.rides if d == draw)
        return [float(self.rides[draw, index]["cost"]) for index in mine]

    def write(self, *, whole: bool) -> dict[str, Any]:
        """Write all draws as JSON; return the record of the best."""
        records = [self._record(draw) for draw in range(len(self.draws))]
        ridden = [each for each in records if each["rides"]]
        most = max((each["rides"] for each in ridden), default=0)
        at_the_top = [each for each in ridden if each["rides"] == most]
        best = min(at_the_top, key=lambda each: each["cost"], default={})
        out = {
            "planner": self.planner,
            "complete": whole,
            "best": best,
            "first_seed": FIRST_SEED,
            "scenes": [scene.label for scene in CYCLE],
            "rungs": RUNGS,
            "space": {
                key: axis.model_dump(exclude_defaults=True) for key, axis in self.axes.items()
            },
            "versions": {part: version(part) for part in PARTS_THAT_COUNT},
            "code": self.code,
            "draws": records,
        }
        text = json.dumps(out, indent=1) + "\n"
        (self.folder / f"{self.planner}.json").write_text(text, encoding="utf-8")
        if best:
            print(
                f"\n{self.planner}: draw {best['draw']} costs {best['cost']:.3f} over "
                f"{best['rides']} rides; default {records[0].get('cost', float('nan')):.3f} "
                f"over {records[0]['rides']}"
            )
        return best

    def _record(self, draw: int) -> dict[str, Any]:
        rows = [self.rides[each] for each in sorted(self.rides) if each[0] == draw]
        record = {"draw": draw, "rides": len(rows), "parameters": self.draws[draw]}
        if not rows:
            return record
        means = {
            key: round(sum(float(row[key]) for row in rows) / len(rows), 4)
            for key in ("cost", *PARTS)
        }
        reached = sum(row["outcome"] == "reached" for row in rows) / len(rows)
        return {**record, "reached": round(reached, 4), **means}

    def _tasks(self, todo: Iterable[tuple[int, int]]) -> list[tuple[int, Training]]:
        return [
            (draw, Training(self.planner, tuple(self.draws[draw].items()), index))
            for draw, index in todo
        ]

    def _key(self, draw: int, index: int) -> str:
        """Key of a ride: everything that determines it."""
        training = Training(self.planner, tuple(self.draws[draw].items()), index)
        text = repr((training, training.scene, training.seed, self.code))
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    @property
    def _file(self) -> Path:
        return self.folder / f"{self.planner}.csv"

    def _known(self) -> dict[str, dict[str, Any]]:
        """Rides of an earlier call that are still valid."""
        rows: list[dict[str, Any]] = []
        if self._file.is_file():
            with self._file.open(newline="", encoding="utf-8") as stream:
                rows = [row for row in csv.DictReader(stream) if row.get("error") is not None]
        wanted = {
            self._key(draw, index)
            for draw in range(len(self.draws))
            for index in range(RUNGS[-1][1])
        }
        known = {row["key"]: row for row in rows if row["key"] in wanted}
        with self._file.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(known.values())
        return known

    def _keep(self, draw: int, index: int, row: dict[str, Any]) -> None:
        short = {k: f"{each:.6g}" if isinstance(each, float) else each for k, each in row.items()}
        row = {"key": self._key(draw, index), "draw": draw, "ride": index, **short}
        self.rides[draw, index] = row
        with self._file.open("a", newline="", encoding="utf-8") as stream:
            csv.DictWriter(stream, COLUMNS, lineterminator="\n").writerow(row)


def write_best(planner: str, best: dict[str, Any], count: int) -> None:
    """Write the best draw to the file that the benchmarks read."""
    head = (
        f"# Found by benchmarks/tune.py among {count} draws: mean cost {best['cost']:.3f} over "
        f"{best['rides']} rides,\n# {100 * best['reached']:.0f} % of them reached.\n"
    )
    found = nested(best["parameters"])
    body = yaml.safe_dump(found, sort_keys=False) if found else "# The defaults were best.\n"
    tuned_file(planner).write_text(head + body, encoding="utf-8")


def code_digest() -> str:
    """Digest of all code that affects a ride."""
    root = Path(cohelm.__file__).parent
    digest = hashlib.sha256()
    for file in sorted([*root.rglob("*.py"), *root.rglob("*.yaml")]):
        where = file.relative_to(root)
        if not set(where.parts) & set(NO_PART_OF_RIDES):
            digest.update(str(where).encode() + file.read_bytes())
    return digest.hexdigest()[:12]


def _ride(numbered: tuple[int, Training]) -> tuple[int, int, dict[str, Any]]:
    draw, training = numbered
    return draw, training.index, training.ride()


def _ignore_interrupt() -> None:
    """Ignore Ctrl-C: the parent process handles it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
