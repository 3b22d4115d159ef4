"""The navigator's process as the chair has it: asked, listened to, and begun anew when it fails."""

from __future__ import annotations

import logging

from cohelm.driving.asking import Answer, Ask, Charge, Ready
from cohelm.driving.navigating import serve
from cohelm.driving.remote import Gone, Remote

HANGING = 10.0
"""A navigator that owes an answer for longer is ended and begun anew, s."""
FALSE_STARTS = 3
"""Navigators that may fail one after the other before they are ready; then no more are begun."""
REST = 1.0
"""Between the ends of two navigators and their successors, s."""
_log = logging.getLogger(__name__)


class Thinking:
    """One navigator after the other.

    Args:
        charge: what each is made with.
    """

    def __init__(self, charge: Charge) -> None:
        self._charge = charge
        self._remote: Remote | None = None
        self._begins_at = 0.0
        self._false_starts = 0
        self.asked_at = 0.0
        """When it was asked last, s."""
        self.asked: Ask | None = None
        """What it owes an answer to."""
        self.owed: Ask | None = None
        """What the last one that is lost owed an answer to."""
        self.ready = False
        """Whether it can be asked."""
        self.lost = ""
        """Why the last one is gone; empty once whoever it concerns has taken note."""
        self.begun = 0
        """How many there have been."""

    @property
    def hopeless(self) -> bool:
        """Whether none is begun any more."""
        return self._false_starts >= FALSE_STARTS

    @property
    def pid(self) -> int | None:
        """Of the process there is."""
        return self._remote.pid if self._remote is not None else None

    @property
    def free(self) -> bool:
        """Whether it waits for a question."""
        return self.ready and self.asked is None

    def attend(self, now: float) -> bool:
        """Begin one where there is none, and hear whether it is ready; whether it just became so.

        Args:
            now: s.
        """
        if self._remote is None:
            if now >= self._begins_at and not self.hopeless:
                self._remote = Remote(serve, self._charge, "cohelm-navigator")
                self.begun += 1
            return False
        if self.ready:
            return False
        said = self._hear(0.0, now)
        while isinstance(said, Ready) and not said.done:
            _log.info("the navigator gets ready: %s", said.what)
            said = self._hear(0.0, now)
        self.ready = isinstance(said, Ready)
        self._false_starts = 0 if self.ready else self._false_starts
        return self.ready

    def ask(self, ask: Ask, now: float) -> None:
        """Ask, where it is free."""
        if not self.free or self._remote is None:
            return
        self.asked, self.asked_at = ask, now
        try:
            self._remote.send(ask)
        except Gone as cause:
            self._lost(now, str(cause))

    def answer(self, timeout: float, now: float) -> Answer | None:
        """The answer to what it was asked, if it comes within ``timeout``, s."""
        if self.asked is None or not self.ready:
            return None
        said = self._hear(timeout, now)
        if isinstance(said, Answer):
            self.asked = None
            return said
        if self._remote is None:
            return None
        if now - self.asked_at > HANGING:
            self._lost(now, f"no answer for {HANGING:g} s")
        return None

    def close(self) -> None:
        """Let it end."""
        if self._remote is not None:
            self._remote.close()
        self._remote, self.ready, self.asked = None, False, None

    def _hear(self, timeout: float, now: float) -> object | None:
        if self._remote is None:
            return None
        try:
            found: object | None = self._remote.receive(timeout)
        except Gone as cause:
            self._lost(now, str(cause))
            return None
        return found

    def _lost(self, now: float, why: str) -> None:
        """It is of no more use: end it, and begin another one a little later."""
        _log.error("the navigator is lost: %s", why)
        self.lost = why
        self._false_starts += not self.ready
        if self._remote is not None:
            self._remote.kill()
        self.owed = self.asked
        self._remote, self.ready, self.asked = None, False, None
        self._begins_at = now + REST
