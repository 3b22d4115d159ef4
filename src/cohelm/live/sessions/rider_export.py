"""Export of all that is stored about one rider, as a ZIP archive.

It has the rider's record, and for each session its stored files, the HTML report and the CSV table.
The audit log is not a part of it: it knows riders by their ids, and other people as well.
"""

from __future__ import annotations

import contextlib
import io
import zipfile

from cohelm.errors import StoreError
from cohelm.live.sessions.archive import SessionArchive
from cohelm.live.sessions.session_files import as_json


def rider_archive(archive: SessionArchive, rider: str) -> bytes:
    """Return the archive of a rider.

    Args:
        archive: Sessions and riders.
        rider: Id.

    Raises:
        StoreError: There is no such rider, or their file is damaged.
    """
    record, out = archive.riders.get(rider), io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as into:
        into.writestr("rider.json", as_json(record))
        for folder in sorted(archive.folders_of(rider)):
            session = folder.name
            with contextlib.suppress(StoreError):  # deleted meanwhile
                into.writestr(f"{session}.html", archive.html(session))
                into.writestr(f"{session}.csv", archive.csv(session))
            for file in sorted(folder.iterdir()):
                with contextlib.suppress(OSError):  # measured meanwhile
                    into.writestr(f"{session}/{file.name}", file.read_bytes())
    return out.getvalue()
