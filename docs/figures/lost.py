"""Draw detections of carried chairs against false alarms: the picture of docs/results/safety.md.

    cohelm bench lost --seeds 100 --out benches/lost
    python docs/figures/lost.py benches/lost

The curve is the fit of scan and map, with breaks of the view, at multiples of the bounds; the point
is the whole monitor.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import matplotlib.pyplot as plt


def main() -> None:
    """Draw the picture from the summary of a result folder."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path)
    options.add_argument("--plot", type=Path, default=Path("docs/images/lost.png"))
    chosen = options.parse_args()
    summary = json.loads((chosen.folder / "summary.json").read_text(encoding="utf-8"))
    summary = summary.get("summary", summary)
    curve = summary["curve"]
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    alarms = [each["alarms"] for each in curve]
    detected = [100.0 * each["detected"] for each in curve]
    axes.plot(
        alarms, detected, ".-", color="tab:blue", label="scan against map and breaks, by threshold"
    )
    bound = min(curve, key=lambda each: abs(each["threshold"] - 1.0))
    axes.plot(bound["alarms"], 100.0 * bound["detected"], "o", color="tab:blue", ms=9, mfc="none")
    axes.plot(
        summary["alarms_per_hour"],
        100.0 * summary["detected_1m"],
        "*",
        color="tab:red",
        ms=13,
        label="whole monitor",
    )
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set(xlabel="false alarms per hour", ylabel="carries of 1 m and more in 2 s, %")
    axes.set_ylim(min(90.0, 0.95 * min(detected)), 100.5)
    axes.grid(color="0.9")
    axes.legend(loc="lower right")
    axes.set_title(
        f"{summary['drives']} drives, {summary['carried']} carried; circle: the bound in use",
        fontsize=9,
    )
    figure.savefig(chosen.plot, dpi=120)


if __name__ == "__main__":
    main()
