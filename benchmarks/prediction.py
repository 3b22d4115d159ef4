"""How well people's ways are foreseen, on filmed crowds and on simulated changes of mind.

    python benchmarks/prediction.py [--crowds FOLDER] [--seeds 3] [--first 0] [--plot FILE]
                                    [--set KEY=VALUE]

The crowds are the text files of ETH and UCY (obsmat.txt) and of HERMES in a folder;
COHELM_DATA/pedestrians where none is named. Without any, the simulated changes alone are run.
"""

import argparse
import os
import time
from pathlib import Path

import numpy as np

from cohelm.config import override, validate
from cohelm.evaluation.changes_of_mind import CHANGES, SOON, Change, changes, noticed
from cohelm.evaluation.foresight import AHEAD, ALARM, alarms, foresee, likelihoods
from cohelm.evaluation.watched import watch
from cohelm.perception import Hypotheses
from cohelm.pictures.futures import Foretold, draw_futures
from cohelm.recordings.trajectories import read_trajectories
from cohelm.testing.scenes import walkers

CROWDS = {"*obsmat.txt": ((10.0, None), AHEAD), "hermes*.txt": ((10.0, 2.5), 1.25)}
"""Rates of the scans, and how far ahead: frames of HERMES lie 1/16 s apart."""


def crowd(file: Path, predictor: Hypotheses, rate: float | None, ahead: float) -> None:
    watched = watch(read_trajectories(file), rate=rate)
    got = likelihoods(watched, predictor, ahead=ahead)
    said = alarms(foresee(watched, predictor, ahead=ahead))
    print(f"{file.name}, scans at {'the moments of the film' if rate is None else f'{rate:g} Hz'}")
    print(f"  {got.frames} frames of {got.people} people")
    print(f"  log-likelihood at {ahead:<4g} s         {got.mean:.3f}")
    print(f"  over the best fixed weights      {got.over_fixed:.4f}, weights {got.fixed.round(4)}")
    print(f"  over average weights             {got.over_usual:.4f}")
    print(f"  over constant velocity           {got.over_constant:.3f}, q = {got.agility:g} m²/s³")
    print(f"  within the 90 % region           {got.within_90:.3f}")
    print(f"  alarms {said.said} ({said.said / said.frames:.4f}),", end=" ")
    print(f"false {said.false} ({said.share:.4f})")


def sudden(seed: int, predictor: Hypotheses) -> None:
    got = noticed(changes(seed), predictor)
    kinds = ", ".join(f"{name} {got.share(name):.3f}" for name in ("stops", "turns"))
    middle = np.median(got.delay)
    print(
        f"seed {seed}: {len(got.names)} changes, noticed within 0.6 s {got.share():.3f} ({kinds})"
    )
    print(f"  median {middle:.2f} s; before the change {got.early} of {got.ticks} ticks said wrong")


def clock(predictor: Hypotheses, people: int = 50, ticks: int = 200) -> None:
    states = np.random.default_rng(0).normal(size=(people, 4))
    memory, spent = None, []
    for k in range(ticks):
        states[:, :2] += 0.1 * states[:, 2:]
        told = walkers(states, time=0.1 * k)
        began = time.thread_time()
        _, memory = predictor.predict(told, 25, 0.1, memory)
        spent.append(time.thread_time() - began)
    low, high = np.quantile(spent[10:], [0.5, 0.99]) * 1e3
    print(f"{people} people, 25 steps: median {low:.2f} ms, p99 {high:.2f} ms, thread CPU time")


def foretold(change: Change, predictor: Hypotheses) -> Foretold:
    memory, predictions = None, []
    seen = [people for people in change.people if len(people) == 1]
    for people in seen:
        told, memory = predictor.predict(people, 12, 0.1, memory)
        predictions.append(told)
    return Foretold(
        title=change.name.replace("_", " "),
        change=change.onset,
        times=np.array([people.time for people in seen]),
        positions=np.array([people.mean[0, :2] for people in seen]),
        predictions=predictions,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    data = os.environ.get("COHELM_DATA")
    parser.add_argument("--crowds", type=Path, default=Path(data) / "pedestrians" if data else None)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    given = parser.parse_args()
    parameters = override(Hypotheses.Parameters().model_dump(), given.set)
    predictor = Hypotheses(validate(Hypotheses.Parameters, parameters))
    if given.plot:
        happened = changes(5, counts=[1] * len(CHANGES))
        draw_futures(
            [foretold(change, predictor) for change in happened],
            given.plot,
            moments=(-0.2, 0.3, 0.6),
            alarm=ALARM,
            soon=SOON,
        )
    clock(predictor)
    for seed in range(given.first, given.first + given.seeds):
        sudden(seed, predictor)
    for files, (rates, ahead) in CROWDS.items() if given.crowds else ():
        for file in sorted(given.crowds.glob(files)):
            for rate in rates:
                crowd(file, predictor, rate, ahead)


if __name__ == "__main__":
    main()
