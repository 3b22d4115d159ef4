"""Export of all that is stored about one rider, as a ZIP archive.

It has the rider's record, and for each session its rides' summaries and logs, the HTML report and
the CSV table.
The audit log is not a part of it: it knows riders by their ids, and other people as well.
"""

from __future__ import annotations

import contextlib
import io
import zipfile

from cohelm.live.sessions.store import SessionStore


def rider_archive(store: SessionStore, rider: str) -> bytes:
    """Return the archive of a rider.

    Args:
        store: Sessions and riders.
        rider: Id.

    Raises:
        StoreError: There is no such rider, or their record is damaged.
    """
    record, out = store.riders.get(rider), io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as into:
        into.writestr("rider.json", record.model_dump_json(indent=1))
        for summary in store.list_of(rider):
            session = summary.session.id
            into.writestr(f"{session}.html", store.html(session))
            into.writestr(f"{session}.csv", store.csv(session))
            into.writestr(f"{session}.json", summary.model_dump_json(indent=1))
            for ride in summary.rides:
                with contextlib.suppress(OSError):  # deleted meanwhile, or nothing of it was stored
                    into.write(store.log_file(ride.id), f"{ride.id}.mcap")
    return out.getvalue()
