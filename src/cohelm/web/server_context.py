"""Parts of one server, and the session of a request."""

from __future__ import annotations

import math
import time
from typing import Any

from starlette.requests import HTTPConnection

from cohelm.arrays import value
from cohelm.live import Drive
from cohelm.live.sessions.audit import AuditEvent
from cohelm.web.origins import Origins
from cohelm.web.page_files import BuiltPage
from cohelm.web.signin import Session, SignIns

ANYONE = Session(role="driver", name="driver", ends=math.inf)
"""Session of a client that has not signed in, if it may drive."""


@value
class ServerContext:
    """Parts of one server: drive, page, names and sign-ins."""

    drive: Drive
    page: BuiltPage
    origins: Origins
    sign_ins: SignIns
    port: int
    open_to_drivers: bool
    """True if driving needs no token, because only this machine can reach the server."""

    @property
    def cookie(self) -> str:
        """Name of the cookie, with the port, because browsers share cookies between ports."""
        return f"{'__Host-' if self.origins.tls else ''}cohelm-{self.port}"

    def cookie_of(self, connection: HTTPConnection) -> str | None:
        """Return the text of a request's cookie; None: it has none."""
        return connection.cookies.get(self.cookie)

    def session(self, connection: HTTPConnection) -> Session | None:
        """Return the session of a request; None: not signed in."""
        session = self.sign_ins.session(self.cookie_of(connection), time.monotonic())
        return session or (ANYONE if self.open_to_drivers else None)

    def log_event(self, actor: str, event: AuditEvent, **details: Any) -> None:
        """Add an entry to the audit log."""
        self.drive.audit.log_event(actor, event, **details)


def address_of(connection: HTTPConnection) -> str:
    """Return the address of a request's client."""
    return connection.client.host if connection.client else ""
