"""Server of a recording: its page and its timeline, on this machine only."""

from __future__ import annotations

from collections.abc import Callable

import uvicorn
from fastapi import FastAPI, Request, Response
from starlette.exceptions import HTTPException

from cohelm.errors import ConfigError
from cohelm.live.sessions.timeline import Timeline
from cohelm.web.guard import Guard
from cohelm.web.origins import is_loopback, names_of, origins_for
from cohelm.web.page_files import BuiltPage
from cohelm.web.server import Server

ENTRY = "replay.html"
"""Page of a recording."""


def replay_app(timeline: Timeline, page: BuiltPage, host: str) -> FastAPI:
    """Return the application that shows a recording.

    Args:
        timeline: Content of the recording.
        page: Files of the page.
        host: Name that the server listens on.

    Raises:
        ConfigError: Other machines can reach the host.
    """
    if not is_loopback(host):
        raise ConfigError("a recording is shown on this machine only", key=f"--host {host}")
    content = timeline.model_dump_json().encode()
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False)

    @app.get("/api/replay")
    async def replay() -> Response:
        return Response(content, media_type="application/json")

    @app.get("/{path:path}")
    async def file(path: str, request: Request) -> Response:
        asset = page.get(path or ENTRY)
        if asset is None:
            raise HTTPException(404)
        return asset.response(request)

    app.add_middleware(Guard, origins=origins_for(host, tls=False, names=names_of(host)))
    return app


def replay_server(app: FastAPI, started: Callable[[], None] = lambda: None) -> uvicorn.Server:
    """Return the server, which ends by a signal or once ``should_exit`` is set."""
    config = uvicorn.Config(app, log_config=None, log_level="error", server_header=False)
    return Server(config, started)
