"""Files of the built page: read and compressed once; no other file is served."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response

from cohelm.arrays import value
from cohelm.errors import ConfigError

FOLDER = Path(__file__).with_name("page")
_ENTRIES = {"": "index.html", "therapist": "therapist.html"}
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".webmanifest": "application/manifest+json",
    ".png": "image/png",
    ".ico": "image/x-icon",
}
"""Media types by suffix; other files are not served."""
_COMPRESSED = frozenset({".png", ".ico"})
_CACHE_FOR_EVER = "public, max-age=31536000, immutable"


@value
class Asset:
    """File of the page, and its compressed content if that is shorter."""

    body: bytes
    zipped: bytes | None
    kind: str
    tag: str
    lasting: bool
    """True if its name changes with its content, so that browsers may cache it for ever."""

    def response(self, request: Request) -> Response:
        """Return the answer to a request: the file, or that the browser has it already."""
        headers = {
            "ETag": self.tag,
            "Cache-Control": _CACHE_FOR_EVER if self.lasting else "no-cache",
            "Vary": "Accept-Encoding",
        }
        if self.tag in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=headers)
        body = self.body
        if self.zipped is not None and "gzip" in request.headers.get("accept-encoding", ""):
            headers["Content-Encoding"] = "gzip"
            body = self.zipped
        return Response(body, media_type=self.kind, headers=headers)


BuiltPage = dict[str, Asset]
"""Files by path, without a leading slash."""


def read_page(folder: Path = FOLDER) -> BuiltPage:
    """Return all files of the built page.

    Raises:
        ConfigError: The page has not been built.
    """
    if not (folder / "index.html").is_file():
        raise ConfigError(
            "the page has not been built; 'make page' builds it (it needs Node), "
            "and an installed wheel brings it along",
            file=folder,
        )
    files = (file for file in sorted(folder.rglob("*")) if file.is_file() and file.suffix in _TYPES)
    page = {file.relative_to(folder).as_posix(): _asset(file, folder) for file in files}
    for path, name in _ENTRIES.items():
        page[path] = page.get(name, page["index.html"])
    return page


def _asset(file: Path, folder: Path) -> Asset:
    body = file.read_bytes()
    zipped = None if file.suffix in _COMPRESSED else gzip.compress(body, mtime=0)
    return Asset(
        body=body,
        zipped=zipped if zipped is not None and len(zipped) < len(body) else None,
        kind=_TYPES[file.suffix],
        tag=f'"{hashlib.sha256(body).hexdigest()[:20]}"',
        lasting=file.relative_to(folder).parts[0] == "assets",
    )
