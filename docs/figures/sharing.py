"""Draw arrivals without collision per family and mode: the picture of docs/sharing-study.md.

    cohelm bench sharing --out benches/sharing
    python docs/figures/sharing.py benches/sharing

Each bar is the share of rides that arrived as the rider wanted, with its 95 % Wilson interval.
"""

from __future__ import annotations

import argparse
import csv
import textwrap
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from cohelm.benchmarks.rides.modes import MODES
from cohelm.benchmarks.rides.sharing_families import FAMILIES
from cohelm.benchmarks.rides.sharing_report import BY, OUTCOME
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import wilson_share

COLOURS = ("#9aa5b1", "#6b7785", "#3d5a98", "#c2185b", "#0b7a75")
WIDTH = 0.16


def main() -> None:
    """Draw the picture."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path, help="result folder of cohelm bench sharing")
    options.add_argument("--plot", type=Path, default=Path("docs/images/sharing.png"))
    chosen = options.parse_args()
    with (chosen.folder / "rows.csv").open(encoding="utf-8") as file:
        rides = Rides(list(csv.DictReader(file)), BY)
    families = [name for name in FAMILIES if len(rides.only(family=name))]
    figure, axes = plt.subplots(figsize=(9, 3.6), layout="constrained")
    for k, (mode, colour) in enumerate(zip(MODES, COLOURS, strict=True)):
        at = np.arange(len(families)) + (k - (len(MODES) - 1) / 2) * WIDTH
        met = [rides.only(family=name, mode=mode).column(OUTCOME) > 0.0 for name in families]
        found = [wilson_share(each) for each in met]
        mean, low, high = (
            100.0 * np.array([getattr(each, key) for each in found])
            for key in ("mean", "low", "high")
        )
        axes.bar(at, mean, WIDTH * 0.9, color=colour, label=mode)
        spread = np.clip([mean - low, high - mean], 0.0, None)
        axes.errorbar(at, mean, spread, fmt="none", ecolor="0.15", elinewidth=1.0, capsize=2)
    titles = [f"{name}\n{textwrap.fill(FAMILIES[name].title, 22)}" for name in families]
    axes.set_xticks(np.arange(len(families)), titles, fontsize=7.5)
    axes.set(ylim=(0, 103), ylabel="arrived as the rider wanted, %")
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside upper center", ncols=len(MODES), fontsize=8, frameon=False)
    figure.savefig(chosen.plot, dpi=120)


if __name__ == "__main__":
    main()
