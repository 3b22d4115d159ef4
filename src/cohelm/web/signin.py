"""Sign-in by tokens: sessions, and delays after wrong tokens.

Only digests of tokens and cookies are kept. Times are seconds of a monotonic clock and come from
outside. All of it belongs to the server's thread.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
from collections import OrderedDict
from collections.abc import Callable

from cohelm.arrays import value
from cohelm.live.messages import Role

SESSION_DURATION = 12 * 3600.0
"""Time after which a session ends, s."""
MAX_SESSIONS = 64
"""Maximum number of sessions; a new one ends the oldest."""
LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"
"""Letters of a token: none looks like another."""
_GROUPS, _GROUP = 4, 5


def new_token() -> str:
    """Return a token that a person can type: four groups of five letters, 99 bits."""
    return "-".join("".join(secrets.choice(LETTERS) for _ in range(_GROUP)) for _ in range(_GROUPS))


@value
class Session:
    """Session of a client that has signed in."""

    role: Role
    name: str
    """Name for the audit log, as ``therapist 1``."""
    ends: float
    """Time of its end, s."""


class WrongToken(Exception):
    """The token is not valid."""


class SignInLocked(Exception):
    """Too many wrong tokens: for ``wait`` more seconds, even a right one is rejected."""

    def __init__(self, wait: float) -> None:
        self.wait = wait
        super().__init__(f"too many wrong tokens; try again in {wait:.0f} s")


class Lockout:
    """Delay after failures that doubles with each further one.

    Args:
        free: Number of failures without a delay.
        longest: Maximum delay, s.
        forgets: Time without a failure after which the count begins again, s.
    """

    def __init__(self, *, free: int, longest: float, forgets: float = 900.0) -> None:
        self._free, self._longest, self._forgets = free, longest, forgets
        self.failures = 0
        self._last = 0.0
        self.until = 0.0

    def failed(self, now: float) -> None:
        """Count one more failure."""
        if now - self._last > self._forgets:
            self.failures = 0
        self.failures += 1
        self._last = now
        beyond = self.failures - self._free
        if beyond > 0:
            self.until = now + min(self._longest, 2.0 ** min(beyond - 1, 30))

    def wait(self, now: float) -> float:
        """Return the remaining delay, s."""
        return max(0.0, self.until - now)


class SignIns:
    """Valid tokens, open sessions, and delays after wrong tokens.

    Args:
        tokens: Token of each role that has one.
        secret: Returns the text of a new cookie.
    """

    _MAX_ADDRESSES = 1024

    def __init__(
        self,
        tokens: dict[Role, str],
        secret: Callable[[], str] = lambda: secrets.token_urlsafe(32),
    ) -> None:
        self._tokens = {role: _digest(_plain(token)) for role, token in tokens.items()}
        self._secret = secret
        self._sessions: OrderedDict[bytes, Session] = OrderedDict()
        self._count = 0
        self._all = Lockout(free=30, longest=60.0)
        self._each: OrderedDict[str, Lockout] = OrderedDict()

    def sign_in(self, token: str, address: str, now: float) -> tuple[str, Session]:
        """Return the text of a new cookie, and its session.

        Raises:
            WrongToken, SignInLocked: See :meth:`role`.
        """
        return self._open(self.role(token, address, now), now)

    def role(self, token: str, address: str, now: float) -> Role:
        """Return the role of a token, without a session.

        Raises:
            WrongToken: The token is not valid; all valid ones are compared, in constant time.
            SignInLocked: There were too many wrong tokens, from this address or in all.
        """
        where = self._lockout(address)
        wait = where.wait(now)
        if where.failures:  # an address without a failure does not wait for others
            wait = max(wait, self._all.wait(now))
        if wait > 0.0:
            raise SignInLocked(wait)
        given = _digest(_plain(token))
        fits = [role for role, own in self._tokens.items() if hmac.compare_digest(own, given)]
        if not fits:
            where.failed(now)
            self._all.failed(now)
            raise WrongToken
        self._each.pop(_network(address), None)
        return fits[0]

    def session(self, cookie: str | None, now: float) -> Session | None:
        """Return the session of a cookie; None: there is none, or it has ended."""
        if not cookie:
            return None
        key = _digest(cookie)
        found = self._sessions.get(key)
        if found is not None and found.ends <= now:
            del self._sessions[key]
            return None
        return found

    def sign_out(self, cookie: str | None) -> Session | None:
        """End the session of a cookie; returns it if there was one."""
        return self._sessions.pop(_digest(cookie), None) if cookie else None

    def _open(self, role: Role, now: float) -> tuple[str, Session]:
        self._count += 1
        session = Session(role=role, name=f"{role} {self._count}", ends=now + SESSION_DURATION)
        cookie = self._secret()
        self._sessions[_digest(cookie)] = session
        while len(self._sessions) > MAX_SESSIONS:
            self._sessions.popitem(last=False)
        return cookie, session

    def _lockout(self, address: str) -> Lockout:
        """Return the lockout of an address; beyond a maximum the oldest one is forgotten."""
        key = _network(address)
        found = self._each.pop(key, None) or Lockout(free=3, longest=600.0)
        self._each[key] = found
        while len(self._each) > self._MAX_ADDRESSES:
            self._each.popitem(last=False)
        return found


def _plain(token: str) -> str:
    """Return a token in lower case without hyphens."""
    return "".join(letter for letter in token.lower() if letter.isalnum())


def _digest(text: str) -> bytes:
    return hashlib.sha256(text.encode("utf-8", errors="surrogatepass")).digest()


def _network(address: str) -> str:
    """Return the unit of lockout: an IPv4 address or an IPv6 network of /64."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return address
    if found.version == 6:
        return str(ipaddress.ip_network((found, 64), strict=False))
    return str(found)
