"""Application of the server: guard, API, socket and page."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI, Request, Response, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from cohelm.errors import CohelmError
from cohelm.web import api, problems, riders_api
from cohelm.web.guard import Guard
from cohelm.web.origins import VIEWER_PATH, Refusal
from cohelm.web.page_connections import PageConnections
from cohelm.web.page_files import Asset
from cohelm.web.server_context import ServerContext, address_of
from cohelm.web.signin import SignInLocked, WrongToken
from cohelm.web.viewers import Viewers, token_of

_SIGN_IN = Refusal(status=401, code="sign_in", text="sign in first")

router = APIRouter()


def create_app(server_context: ServerContext) -> FastAPI:
    """Return the application of one server; the caller starts and closes the drive."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.pages = PageConnections(server_context.drive)
        if server_context.origins.viewers:
            app.state.viewers = Viewers(server_context.drive)
        yield

    app = FastAPI(
        title="cohelm",
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        docs_url=None,  # it loads its scripts from elsewhere
        redoc_url=None,
        redirect_slashes=False,
    )
    app.state.server_context = server_context
    app.add_exception_handler(problems.RequestRefused, problems.on_refused)
    app.add_exception_handler(RequestValidationError, problems.on_invalid)
    app.add_exception_handler(CohelmError, problems.on_failed)
    app.add_exception_handler(HTTPException, problems.on_unknown)
    app.include_router(api.router)
    app.include_router(riders_api.router)
    app.include_router(router)
    app.add_middleware(Guard, origins=server_context.origins)
    return app


@router.websocket("/ws")
async def socket(websocket: WebSocket) -> None:
    """Serve the socket of a page, or refuse it before it is open."""
    server_context: ServerContext = websocket.app.state.server_context
    pages: PageConnections = websocket.app.state.pages
    session = server_context.session(websocket)
    address = address_of(websocket)
    refusal = _SIGN_IN if session is None else pages.refusal(address, time.monotonic())
    if session is None or refusal is not None:
        await _refuse(websocket, refusal or _SIGN_IN)
        return
    await pages.serve(websocket, session, address)


@router.websocket(VIEWER_PATH)
async def viewer(websocket: WebSocket) -> None:
    """Serve the socket of a viewer, or refuse it before it is open."""
    server_context: ServerContext = websocket.app.state.server_context
    refusal = _viewer_refusal(websocket, server_context)
    if refusal is not None:
        await _refuse(websocket, refusal)
        return
    await websocket.app.state.viewers.serve(websocket)


async def _refuse(websocket: WebSocket, refusal: Refusal) -> None:
    answer = JSONResponse({"code": refusal.code, "text": refusal.text}, refusal.status)
    await websocket.send_denial_response(answer)


def _viewer_refusal(websocket: WebSocket, server_context: ServerContext) -> Refusal | None:
    """Reason to refuse a viewer: beyond this machine it needs a token in its address."""
    if not server_context.origins.viewers:
        return Refusal(status=404, code="not_found", text="start with --viewer to allow viewers")
    if not server_context.open_to_drivers:
        token, address = token_of(websocket), address_of(websocket)
        try:
            server_context.sign_ins.role(token, address, time.monotonic())
        except (WrongToken, SignInLocked):
            return _SIGN_IN
    full = Refusal(status=503, code="full", text="too many viewers are open; close one")
    return full if websocket.app.state.viewers.full else None


@router.get("/{path:path}", include_in_schema=False)
async def page(path: str, request: Request) -> Response:
    """Return a file of the built page."""
    asset: Asset | None = request.app.state.server_context.page.get(path)
    if asset is None:
        raise HTTPException(404)
    return asset.response(request)
