"""Run two rides of a changed scenario, and measure both.

A box that is not on the map stands on the route. The rider pushes the stick to the left in the
first ride and to the right in the second; the chair passes on that side in both.
"""

import numpy as np

from cohelm.evaluation import Ride, measure, run
from cohelm.scenarios import load_scenario


def side_of_the_box(ride: Ride) -> str:
    """Side of (7, 7) on which the chair passed, seen in the direction of travel."""
    beside = np.argmin(np.abs(ride.pose[:, 0] - 7.0))
    return "left" if ride.pose[beside, 1] > 7.0 else "right"


def main() -> None:
    for side in ("left", "right"):
        changes = [f"rider.side={side}", "goal=[10.5, 7]"]
        ride = run(load_scenario("box", changes), seed=0)
        figures = measure(ride)
        print(
            f"pushed to the {side:5}: {ride.outcome.value}, passed on the {side_of_the_box(ride)}, "
            f"{figures['time']:.1f} s, {figures['path_length']:.2f} m, η up to {ride.eta.max():.2f}"
        )


if __name__ == "__main__":
    main()
