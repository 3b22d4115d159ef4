"""Prices of wishes as the chair has them asked: one question after the other, none waited for."""

from __future__ import annotations

import time
from collections import deque

from cohelm.driving.asking import Charge, Ready
from cohelm.driving.hearing import Tell
from cohelm.driving.messages import Preview, Refused, Want
from cohelm.driving.previews import Price, WhatIf, serve_previews
from cohelm.driving.remote import Gone, Remote
from cohelm.driving.wanted import wish_of, wishes_of

WAITING = 8
"""Questions that wait at most; the oldest is refused where more come."""
HANGING = 25.0
"""A process that owes an answer for longer is ended, s; a page waits for one somewhat longer."""
MOST_LOST = 5
"""Processes that may fail before no more are begun."""


class Pricing:
    """The process that plans what might be, and who waits for its answers.

    Args:
        charge: what it is made with.
        tell: the answers.
    """

    def __init__(self, charge: Charge, tell: Tell) -> None:
        self._charge, self._tell = charge, tell
        self._remote: Remote | None = None
        self._ready = False
        self._lost_ones = 0
        self._asked: WhatIf | None = None
        self._asked_at = 0.0
        self._waiting: deque[tuple[str, Want]] = deque()

    @property
    def wanted(self) -> bool:
        """Whether a question waits for what the chair's surroundings are now."""
        return self._ready and self._asked is None and bool(self._waiting)

    @property
    def settled(self) -> bool:
        """Whether the process is ready, or there is no waiting for it."""
        return self._ready or self._lost_ones > 0

    def ask(self, client: str, want: Want) -> None:
        """What a wish would cost; a newer question of the same page takes an older one's place."""
        if self._lost_ones >= MOST_LOST:
            self._refuse(client, want.id)
            return
        others = [each for each in self._waiting if each[0] != client]
        for mine in [each for each in self._waiting if each[0] == client]:
            self._refuse(mine[0], mine[1].id)
        self._waiting = deque([*others, (client, want)])
        if len(self._waiting) > WAITING:
            oldest, what = self._waiting.popleft()
            self._refuse(oldest, what.id)

    def surrounded(self, surroundings: bytes) -> None:
        """What is about the chair now; empty: it leads nowhere."""
        if not self._waiting or self._remote is None:
            return
        client, want = self._waiting.popleft()
        if not surroundings:
            text = "Choose where to go first."
            self._tell(Refused(id=want.id, code="no_destination", text=text), client)
            return
        wish = wishes_of((wish_of(want, 0),))[0]
        self._asked = WhatIf(id=want.id, client=client, wish=wish, surroundings=surroundings)
        self._asked_at = time.monotonic()
        try:
            self._remote.send(self._asked)
        except Gone:
            self._lost()

    def begin(self) -> None:
        """Start the process, where there is none and it does not fail again and again."""
        if self._remote is None and self._lost_ones < MOST_LOST:
            self._remote = Remote(serve_previews, self._charge, "cohelm-previews")

    def attend(self) -> None:
        """Pass on what it has answered."""
        if self._remote is None:
            return
        try:
            said = self._remote.receive(0.0)
        except Gone:
            self._lost()
            return
        if said is None and self._asked is not None:
            if time.monotonic() - self._asked_at > HANGING:
                self._lost()
            return
        if isinstance(said, Ready):
            self._ready = True
        if isinstance(said, Price):
            self._asked = None
            told = Preview(
                id=said.id,
                points=said.points,
                length=said.length,
                extra=said.extra,
                trouble=said.trouble,
            )
            self._tell(told, said.client)

    def close(self) -> None:
        """Let it end."""
        if self._remote is not None:
            self._remote.close()
        self._remote, self._ready = None, False

    def _lost(self) -> None:
        """Let another one be begun; what was asked is refused."""
        if self._remote is not None:
            self._remote.kill()
        self._remote, self._ready = None, False
        self._lost_ones += 1
        asked, self._asked = self._asked, None
        if asked is not None:
            self._refuse(asked.client, asked.id)

    def _refuse(self, client: str, number: int) -> None:
        text = "I did not find out what that would cost."
        self._tell(Refused(id=number, code="no_preview", text=text), client)
