"""A rider's preference between routes, learned from the choices stored with their rides.

A choice is a part of the summary of its ride and is deleted with it; nothing else is stored. The
last reset of what was learned from rides counts here, too.
"""

from __future__ import annotations

from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import stored_sessions
from cohelm.live.sessions.response import LATEST, reset_at
from cohelm.planning.alternatives.learned_preference import FeatureVector, learn_weights


def learned_preference(database: Database, rider: str) -> FeatureVector | None:
    """Learn the weights of a rider from the latest choices; None if there are too few.

    Args:
        database: Stored rides.
        rider: Id of the rider; empty: the rides of which nobody was chosen as the rider.

    Raises:
        StoreError: The database cannot be read.
    """
    since = reset_at(database)
    rides = [
        ride
        for each in stored_sessions(database)
        if each.session.rider == rider
        for ride in each.rides
        if ride.choice is not None and ride.started >= since
    ]
    rides.sort(key=lambda ride: ride.started)
    return learn_weights(ride.choice for ride in rides[-LATEST:] if ride.choice is not None)
