"""HTTP API of riders, all of it for the therapist alone."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response
from pydantic import Field

from cohelm.config import Model
from cohelm.live.rider_choice import DeletedRider, RiderList
from cohelm.live.sessions.progress import RiderProgress
from cohelm.live.sessions.riders import RiderDraft, RiderRecord
from cohelm.web.api import PROBLEMS, Here, Therapist

router = APIRouter(prefix="/api/riders", responses=PROBLEMS)
RiderId = Annotated[str, Path(pattern=r"^rider-[0-9a-f]{8}$")]


class ChosenRider(Model):
    """Choice of who rides."""

    rider: Annotated[str, Field(max_length=40)]
    """Id; empty: nobody."""


@router.get("")
def riders(_: Therapist, here: Here) -> RiderList:
    """Return all riders, and who rides."""
    return here.drive.riders.list()


@router.post("", status_code=201)
def create_rider(given: RiderDraft, who: Therapist, here: Here) -> RiderRecord:
    """Store a new rider."""
    return here.drive.riders.create(given, who.name)


@router.put("/current")
def choose_rider(given: ChosenRider, who: Therapist, here: Here) -> RiderList:
    """Choose who rides, and put their preset in force; only while the chair stands."""
    return here.drive.riders.choose(given.rider, who.name)


@router.put("/{rider}")
def change_rider(rider: RiderId, given: RiderDraft, who: Therapist, here: Here) -> RiderRecord:
    """Replace what is stored about a rider."""
    return here.drive.riders.change(rider, given, who.name)


@router.delete("/{rider}")
def delete_rider(rider: RiderId, who: Therapist, here: Here) -> DeletedRider:
    """Delete a rider with all their sessions."""
    return here.drive.riders.delete(rider, who.name)


@router.get("/{rider}/progress")
def progress(rider: RiderId, _: Therapist, here: Here) -> RiderProgress:
    """Return the progress of a rider over their sessions."""
    return here.drive.riders.progress(rider)


@router.get("/{rider}.zip", response_class=Response)
def export_rider(rider: RiderId, who: Therapist, here: Here) -> Response:
    """Return all that is stored about a rider as a ZIP archive, named by the id alone."""
    headers = {"Content-Disposition": f'attachment; filename="cohelm-{rider}.zip"'}
    content = here.drive.riders.export(rider, who.name)
    return Response(content, media_type="application/zip", headers=headers)
