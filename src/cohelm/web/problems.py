"""What goes wrong for somebody who asks, always in the same form: a code, and words."""

from __future__ import annotations

from collections.abc import Mapping

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from cohelm.config import Model
from cohelm.driving import LimitsRise
from cohelm.errors import CohelmError, StoreError

_WORDS = {404: "there is nothing here", 405: "that cannot be done here"}


class Problem(Model):
    """Why something asked for was not done."""

    code: str
    """A stable word."""
    text: str


class Refused(Exception):
    """Something asked for is not done."""

    def __init__(
        self, status: int, code: str, text: str, headers: Mapping[str, str] | None = None
    ) -> None:
        self.status, self.code, self.headers = status, code, headers
        super().__init__(text)


async def refused(_: Request, error: Exception) -> JSONResponse:
    """Of :class:`Refused`."""
    assert isinstance(error, Refused)
    return _answer(error.status, error.code, str(error), error.headers)


async def invalid(_: Request, error: Exception) -> JSONResponse:
    """Of a body that is not what it must be: the first fault, without repeating what was sent."""
    assert isinstance(error, RequestValidationError)
    first = error.errors()[0]
    where = ".".join(str(part) for part in first["loc"] if part != "body")[:80]
    return _answer(422, "invalid", f"{where}: {first['msg']}"[:300] if where else first["msg"])


async def failed(_: Request, error: Exception) -> JSONResponse:
    """Of what cohelm itself cannot do."""
    assert isinstance(error, CohelmError)
    if isinstance(error, LimitsRise):
        return _answer(409, error.code, str(error))
    if isinstance(error, StoreError) and error.file is None:
        return _answer(404, error.code, error.problem)
    return _answer(409, error.code, getattr(error, "problem", str(error)))


async def unknown(_: Request, error: Exception) -> JSONResponse:
    """Of a path or a method that there is not."""
    assert isinstance(error, HTTPException)
    text = _WORDS.get(error.status_code, str(error.detail))
    return _answer(error.status_code, f"http_{error.status_code}", text, error.headers)


def _answer(
    status: int, code: str, text: str, headers: Mapping[str, str] | None = None
) -> JSONResponse:
    return JSONResponse(
        {"code": code, "text": text}, status, headers=None if headers is None else dict(headers)
    )
