"""A benchmark that takes no time, and tasks of which fail in every way there is.

It lies in a folder of its own, so that processes can import it by its name.
"""

import math
import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.benchmarks.bench import BenchReport, Result, Sheet

TITLE = "Toy"
SEEDS = 6
WORKERS = 1


@dataclass(frozen=True)
class Toy:
    """Its tasks by what becomes of them: ``fails`` is {seed: how}."""

    fails: tuple[tuple[int, str], ...] = ()
    marks: Path | None = None
    """Where a task leaves a file each time it is begun."""
    takes: float = 0.0
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds):
        return [(seed, f"task {seed}") for seed in seeds]

    def work(self, task, folder):
        seed, word = task
        times = self._begun(seed)
        time.sleep(self.takes)
        how = dict(self.fails).get(seed, "")
        if how == "raises":
            raise ZeroDivisionError(f"no {word}\nat all")
        if how == "exits" or (how == "exits once" and times == 1):
            os._exit(3)
        if how == "leaves":
            sys.exit(4)
        if how == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "no row":
            return [Result({"seed": object()})]
        rng = np.random.default_rng(seed)
        (folder / f"file-{seed}.txt").write_text(word)
        row = {
            "seed": seed, "word": word, "draw": rng.random(), "third": np.float32(1 / 3),
            "count": np.int64(seed), "odd": np.bool_(seed % 2), "nothing": math.nan,
            "far": math.inf,
        }  # fmt: skip
        return [Result(row, {"noise": rng.random((3, 2))}), Result({**row, "word": "none"})]

    def report(self, results, folder):
        total = sum(each.row["draw"] for each in results)
        sheet = Sheet("sum", ("of", "is"), (("draws", f"{total:.6f}"),))
        return BenchReport((sheet,), ("that is all",), {"total": total})

    def _begun(self, seed):
        if self.marks is None:
            return 0
        times = len(list(self.marks.glob(f"{seed}-*"))) + 1
        (self.marks / f"{seed}-{times}").touch()
        return times


def create(fails=(), marks=None, takes=0.0):
    return Toy(tuple(fails), marks, takes)


class NoStart(Toy):
    """Not to be had in another process: that one ends when it unpacks this."""

    def __reduce__(self):
        return os._exit, (7,)
