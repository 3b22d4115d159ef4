"""Measure STOP behind floods of connections from the same address.

    python benchmarks/stop_floods.py --times 3

A server with a chair that stands is flooded on this computer, by a bounded number of connections of
each kind. STOP is pressed as a new client does: once right behind the burst, then again and again.
Printed are the times from the press to the answer, which follows the chair's.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.web.conftest import TOKENS, Served, Still
from tests.web.test_stop_under_floods import FLOODS, WITHIN, flooded, measured

from cohelm.web.connections import MAX_CONNECTIONS, MAX_CONNECTIONS_PER_ADDRESS


def main() -> int:
    """Flood and print the figures; 1 if a STOP took longer than it may."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--times", type=int, default=3, help="floods of each kind and size")
    chosen = options.parse_args()
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    worst, drive = 0.0, Still()
    with Served(drive, tokens={"therapist": TOKENS["therapist"]}) as server:
        measured(server, drive)  # the first requests import and compile
        for kind in FLOODS:
            for held in (MAX_CONNECTIONS_PER_ADDRESS, 2 * MAX_CONNECTIONS):
                first, rest, worked = [], [], []
                for _ in range(chosen.times):
                    with flooded(server, kind, held):
                        took, computing = measured(server, drive)
                    first.append(took[0])
                    rest += [*took[1:]]
                    worked.append(computing.max())
                print(
                    f"{kind}, {held} connections: first STOP max {max(first):.3f} s of "
                    f"{len(first)}; later ones median {np.median(rest):.3f} s, max "
                    f"{max(rest):.3f} s of {len(rest)}; computing max {max(worked):.3f} s",
                    flush=True,
                )
                worst = max(worst, *first, *rest)
    return int(worst > WITHIN)


if __name__ == "__main__":
    raise SystemExit(main())
