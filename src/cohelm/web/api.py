"""HTTP API in JSON; only the therapist changes limits and settings."""

from __future__ import annotations

import time
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, Response
from pydantic import Field

from cohelm.config import Model
from cohelm.live import DriveHealth
from cohelm.live.floor_model import FloorSolids
from cohelm.live.messages import Limits, RiderSettings, Role, StopCommand
from cohelm.live.sessions.audit import AuditEntry
from cohelm.live.sessions.records import SessionSummary
from cohelm.live.sessions.response import RiderResponse, reset_response, stored_response
from cohelm.web.problems import ProblemResponse, RequestRefused
from cohelm.web.schema import messages_schema
from cohelm.web.server_context import ServerContext, address_of
from cohelm.web.signin import SESSION_DURATION, Session, SignInLocked, WrongToken

EXPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox"
"""Content security policy of an exported session: a page without scripts."""
PROBLEMS: dict[int | str, dict[str, Any]] = {
    status: {"model": ProblemResponse}
    for status in (400, 401, 403, 404, 405, 408, 409, 413, 421, 422)
}
"""Error answers of every path, for the description of the API."""

router = APIRouter(prefix="/api", responses=PROBLEMS)


class SignInRequest(Model):
    """Token of a sign-in."""

    token: Annotated[str, Field(min_length=1, max_length=200)]


class Identity(Model):
    """Identity of the client."""

    role: Role
    needs_token: bool
    """True if driving needs a token."""


class SignInResponse(Model):
    """Role of a new sign-in."""

    role: Role


class DeletedSessions(Model):
    """Number of deleted sessions."""

    deleted: int


def server_context(request: Request) -> ServerContext:
    """Return the parts of the server."""
    found: ServerContext = request.app.state.server_context
    return found


Here = Annotated[ServerContext, Depends(server_context)]


def signed_in(request: Request, here: Here) -> Session:
    """Return the session of the request; 401 without one."""
    session = here.session(request)
    if session is None:
        raise RequestRefused(401, "sign_in", "sign in with the token that was printed at the start")
    return session


def therapist(session: Annotated[Session, Depends(signed_in)]) -> Session:
    """Return the session of a therapist; else 403."""
    if session.role != "therapist":
        raise RequestRefused(
            403, "therapist_only", "only the therapist may do this; sign in with theirs"
        )
    return session


SignedIn = Annotated[Session, Depends(signed_in)]
Therapist = Annotated[Session, Depends(therapist)]
SessionId = Annotated[str, Path(pattern=r"^[0-9A-Za-z-]{1,60}$")]


@router.get("/health")
async def health(here: Here) -> DriveHealth:
    """Return the condition of the ride."""
    return here.drive.health


@router.get("/schema")
async def schema() -> dict[str, Any]:
    """Return the JSON Schema of the messages on the socket."""
    return messages_schema()


@router.get("/me")
async def me(session: SignedIn, here: Here) -> Identity:
    """Identity of the client."""
    return Identity(role=session.role, needs_token=not here.open_to_drivers)


@router.post("/sign-in", responses={429: {"model": ProblemResponse}})
async def sign_in(
    given: SignInRequest, request: Request, response: Response, here: Here
) -> SignInResponse:
    """Open a session with a token."""
    where = address_of(request)
    try:
        cookie, session = here.sign_ins.sign_in(given.token, where, time.monotonic())
    except WrongToken:
        here.log_event(where, "sign_in_rejected", address=where)
        raise RequestRefused(401, "wrong_token", "that token does not open anything here") from None
    except SignInLocked as locked:
        wait = {"Retry-After": f"{locked.wait + 1.0:.0f}"}
        raise RequestRefused(429, "locked", str(locked), wait) from None
    here.log_event(session.name, "signed_in", address=where, role=session.role)
    tls = here.origins.tls
    response.set_cookie(
        here.cookie,
        cookie,
        max_age=int(SESSION_DURATION),
        httponly=True,
        samesite="strict",
        secure=tls,
    )
    return SignInResponse(role=session.role)


@router.post("/sign-out", status_code=204)
async def sign_out(request: Request, response: Response, here: Here) -> None:
    """End the session, and close its pages."""
    session = here.sign_ins.sign_out(here.cookie_of(request))
    if session is not None:
        request.app.state.pages.end(session)
        here.log_event(session.name, "signed_out", address=address_of(request))
    response.delete_cookie(here.cookie, httponly=True, samesite="strict", secure=here.origins.tls)


@router.post("/stop", status_code=204)
async def stop(who: SignedIn, here: Here) -> None:
    """Stop the chair, for clients without a socket; has no rate limit."""
    here.drive.receive(who.name, StopCommand(), time.monotonic())


@router.get("/floor/{digest}.png", response_class=Response)
def floor(digest: Annotated[str, Path(max_length=100)], _: SignedIn, here: Here) -> Response:
    """Return the image of the map; its path contains a digest, so that browsers may cache it."""
    if here.drive.scene().floor.image != f"/api/floor/{digest}.png":
        raise RequestRefused(404, "no_floor", "that is not the map that is driven on")
    kept = {"Cache-Control": "private, max-age=31536000, immutable"}
    return Response(here.drive.floor_png(), media_type="image/png", headers=kept)


@router.get("/floor/solids")
async def solids(_: SignedIn, here: Here) -> FloorSolids:
    """Return heights and outlines of what stands on the floor, for the 3-D view."""
    return here.drive.solids


@router.get("/limits")
async def limits(_: SignedIn, here: Here) -> Limits:
    """Return the limits in force."""
    return here.drive.limits


@router.put("/limits")
def set_limits(given: Limits, who: Therapist, here: Here) -> Limits:
    """Change the limits; looser ones only while the chair stands."""
    here.drive.set_limits(given, who.name)
    return here.drive.limits


@router.post("/edges", status_code=204)
def allow_edges(who: Therapist, here: Here) -> None:
    """Let the chair creep over edges of the floor for a short time, while it stands."""
    here.drive.allow_edges(who.name, time.monotonic())


@router.get("/rider")
async def rider(_: SignedIn, here: Here) -> RiderSettings:
    """Return the rider's settings in force."""
    return here.drive.rider


@router.put("/rider")
def set_rider(given: RiderSettings, who: Therapist, here: Here) -> RiderSettings:
    """Change the rider's settings."""
    here.drive.set_rider(given, who.name)
    return here.drive.rider


@router.get("/audit")
def audit(_: Therapist, here: Here) -> tuple[AuditEntry, ...]:
    """Return the audit log, newest first."""
    return here.drive.audit.entries()


@router.get("/sessions")
def sessions(_: Therapist, here: Here) -> tuple[SessionSummary, ...]:
    """Return the sessions with a ride that has ended, the newest first."""
    return here.drive.sessions.list()


@router.delete("/sessions")
def delete_sessions(who: Therapist, here: Here) -> DeletedSessions:
    """Delete all sessions with their rides."""
    count = here.drive.sessions.delete_all()
    here.log_event(who.name, "sessions_deleted", sessions=count)
    return DeletedSessions(deleted=count)


@router.get("/response")
def learned_response(_: Therapist, here: Here) -> RiderResponse:
    """Return what the chair has learned of its rider from the stored rides."""
    return stored_response(here.drive.sessions.database)


@router.delete("/response")
def forget_response(who: Therapist, here: Here) -> RiderResponse:
    """Forget it: rides until now no longer count; takes effect when the drive starts anew."""
    reset_response(here.drive.sessions.database)
    here.log_event(who.name, "response_reset")
    return stored_response(here.drive.sessions.database)


@router.get("/sessions/{session}.html", response_class=Response)
def session_html(session: SessionId, who: Therapist, here: Here) -> Response:
    """Return a session as one HTML document without external resources."""
    text = here.drive.sessions.html(session)
    return _export(here, who, session, text.encode(), "text/html; charset=utf-8", "html")


@router.get("/sessions/{session}.csv", response_class=Response)
def session_csv(session: SessionId, who: Therapist, here: Here) -> Response:
    """Return the rides of a session as a CSV table."""
    text = here.drive.sessions.csv(session)
    return _export(here, who, session, text.encode(), "text/csv; charset=utf-8", "csv")


@router.get("/sessions/{session}.png", response_class=Response)
def session_png(session: SessionId, _: Therapist, here: Here) -> Response:
    """Return the map of a ride, or of the last ride of a session."""
    return Response(here.drive.sessions.png(session), media_type="image/png")


@router.get("/sessions/{ride}.timeline.json", response_class=Response)
def ride_timeline(ride: SessionId, _: Therapist, here: Here) -> Response:
    """Return the timeline of a ride: samples, people, reasons and the map."""
    return Response(here.drive.sessions.timeline(ride), media_type="application/json")


@router.get("/sessions/{session}")
def session_summary(session: SessionId, _: Therapist, here: Here) -> SessionSummary:
    """Return a session with its rides."""
    return here.drive.sessions.summary(session)


def _export(
    here: ServerContext, who: Session, session: str, body: bytes, kind: str, ending: str
) -> Response:
    here.log_event(who.name, "session_exported", session=session, form=ending)
    headers = {
        "Content-Disposition": f'attachment; filename="cohelm-{session}.{ending}"',
        "Content-Security-Policy": EXPORT_POLICY,
    }
    return Response(body, media_type=kind, headers=headers)
