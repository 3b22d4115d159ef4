"""Error answers of the API, always as a code and a text."""

from __future__ import annotations

from collections.abc import Mapping

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from cohelm.config import Model
from cohelm.errors import CohelmError, StoreError
from cohelm.live import LimitsLoosened

_WORDS = {404: "not found", 405: "this method is not allowed"}


class ProblemResponse(Model):
    """Reason why a request was not fulfilled."""

    code: str
    """Stable name of the reason."""
    text: str


class RequestRefused(Exception):
    """A request is not fulfilled."""

    def __init__(
        self, status: int, code: str, text: str, headers: Mapping[str, str] | None = None
    ) -> None:
        self.status, self.code, self.headers = status, code, headers
        super().__init__(text)


async def on_refused(_: Request, error: Exception) -> JSONResponse:
    """Answer a :class:`RequestRefused`."""
    assert isinstance(error, RequestRefused)
    return _answer(error.status, error.code, str(error), error.headers)


async def on_invalid(_: Request, error: Exception) -> JSONResponse:
    """Answer an invalid body with its first fault, without repeating the input."""
    assert isinstance(error, RequestValidationError)
    first = error.errors()[0]
    where = ".".join(str(part) for part in first["loc"] if part != "body")[:80]
    detail = f"{where}: {first['msg']}" if where else first["msg"]
    return _answer(422, "invalid", f"the request is not understood: {detail[:300]}")


async def on_failed(_: Request, error: Exception) -> JSONResponse:
    """Answer an error of cohelm."""
    assert isinstance(error, CohelmError)
    if isinstance(error, LimitsLoosened):
        return _answer(409, error.code, str(error))
    if isinstance(error, StoreError) and error.file is None:
        return _answer(404, error.code, error.problem)
    return _answer(409, error.code, getattr(error, "problem", str(error)))


async def on_unknown(_: Request, error: Exception) -> JSONResponse:
    """Answer an unknown path or method."""
    assert isinstance(error, HTTPException)
    text = _WORDS.get(error.status_code, str(error.detail))
    return _answer(error.status_code, f"http_{error.status_code}", text, error.headers)


def _answer(
    status: int, code: str, text: str, headers: Mapping[str, str] | None = None
) -> JSONResponse:
    return JSONResponse(
        {"code": code, "text": text}, status, headers=None if headers is None else dict(headers)
    )
