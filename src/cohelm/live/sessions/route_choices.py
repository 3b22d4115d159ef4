"""A rider's preference between routes, learned from the choices stored with their rides.

A choice is a part of the summary of its ride and is deleted with it; nothing else is stored. The
last reset of what was learned from rides counts here, too.
"""

from __future__ import annotations

from pathlib import Path

from cohelm.errors import StoreError
from cohelm.live.sessions.records import SessionInfo
from cohelm.live.sessions.response import LATEST, reset_at
from cohelm.live.sessions.session_files import SESSION, read, rides_in
from cohelm.planning.alternatives.learned_preference import FeatureVector, learn_weights


def learned_preference(folder: Path, rider: str) -> FeatureVector | None:
    """Learn the weights of a rider from the latest choices; None if there are too few.

    Args:
        folder: Folder with the sessions.
        rider: Id of the rider; empty: the rides of which nobody was chosen as the rider.

    Raises:
        StoreError: The time of the last reset cannot be read.
    """
    since = reset_at(folder)
    rides = [
        ride
        for session in sorted(folder.glob("*"))
        if SESSION.fullmatch(session.name) and _rider_of(session) == rider
        for ride in rides_in(session)
        if ride.choice is not None and ride.started >= since
    ]
    rides.sort(key=lambda ride: ride.started)
    return learn_weights(ride.choice for ride in rides[-LATEST:] if ride.choice is not None)


def _rider_of(session: Path) -> str | None:
    """Return the rider of a session; None: its file is damaged, and it may be anybody's."""
    try:
        return read(SessionInfo, session / "session.json").rider
    except StoreError:
        return None
