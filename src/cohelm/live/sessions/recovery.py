"""Rides that a killed program left unfinished, and records that are damaged.

While a ride goes on, its folder holds the rows, the inputs of the measures (``.task``) and its
summary so far (``.begun``), at most a second old. A ride with a summary has ended; one without is
finished from these files at the next start. No file of a ride is deleted because another one is
damaged.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np

from cohelm.errors import StoreError
from cohelm.live.sessions.records import RideSummary
from cohelm.live.sessions.ride_rows import ChairColumn, read_rows
from cohelm.live.sessions.session_files import RIDE, read, session_of, unknown_ride

BEGUN = ".begun"
"""Suffix of the summary of a ride that goes on."""
INTERRUPTED = "The program was interrupted during this ride; its last second may be missing."
"""Error of a ride that was finished at the next start."""


def unfinished_rides(root: Path) -> list[str]:
    """Return the ids of all rides without a summary, the oldest first."""
    left = {
        file.stem
        for suffix in (BEGUN, ".rows")
        for file in root.glob(f"*/*{suffix}")
        if file.parent.name == session_of(file.stem)
    }
    return sorted(
        ride
        for ride in left
        if RIDE.fullmatch(ride) and not (root / session_of(ride) / f"{ride}.json").exists()
    )


def interrupted_ride(root: Path, ride: str) -> RideSummary:
    """Return the summary of an unfinished ride, from what can be read of it."""
    file = root / session_of(ride) / ride
    try:
        summary = read(RideSummary, file.with_name(f"{ride}{BEGUN}"))
    except StoreError:
        summary = unknown_ride(ride, "")
    changes: dict[str, object] = {"outcome": "cancelled", "error": INTERRUPTED}
    with contextlib.suppress(StoreError):  # reported when it is measured
        chair, _ = read_rows(file.with_name(f"{ride}.rows"))
        steps = np.diff(chair[:, ChairColumn.POSE][:, :2], axis=0)
        changes["duration"] = round(float(chair[-1, ChairColumn.TIME]), 2)
        changes["length"] = round(float(np.hypot(*steps.T).sum()), 2)
    return summary.model_copy(update=changes)
