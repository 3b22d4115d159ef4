"""Client of the preview process: one request at a time, and no call waits for the answer."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import replace

from cohelm.live.control.ipc import ProcessReady, ProcessSetup
from cohelm.live.control.mission import wishes_of
from cohelm.live.control.worker_process import ProcessGone, WorkerProcess
from cohelm.live.messages import Destination, PlanTrip, Rejected, Send, TripPlans
from cohelm.live.page.preview_process import TripRequest, serve_previews

MAX_QUEUED_PREVIEWS = 8
"""Maximum number of waiting requests; then the oldest is rejected."""
ANSWER_TIMEOUT = 60.0
"""Maximum time for an answer, s; then the process is replaced, which costs a slow computer more
than a minute. A page waits somewhat longer."""
MAX_LOST = 5
"""Number of processes that may fail in a row, without an answer between them.

Then no more are started and all requests are rejected.
"""
_NICENESS = 5
"""Niceness added to that of the server and the navigator: a third of their share of a busy
processor."""


class RoutePreview:
    """Preview process, and the requests that wait for it.

    Args:
        setup: Argument of the process.
        send: Sends the answers.
    """

    def __init__(self, setup: ProcessSetup, send: Send) -> None:
        self._process_setup, self._send = setup, send
        self._process: WorkerProcess | None = None
        self._ready = False
        self._lost = 0
        """Number of lost processes since the last answer."""
        self._pending: TripRequest | None = None
        self._requested_at = 0.0
        self._waiting: deque[TripRequest] = deque()

    @property
    def needs_context(self) -> bool:
        """True if a request waits for the current planning context."""
        return self._ready and self._pending is None and bool(self._waiting)

    @property
    def ready(self) -> bool:
        """True if there is a process that takes requests."""
        return self._ready

    @property
    def ready_or_failed(self) -> bool:
        """True if the process is ready, or has failed once: the chair does not wait longer."""
        return self._ready or self._lost > 0

    def request(self, client: str, trip: PlanTrip, goal: Destination, rider: str) -> None:
        """Request the routes of a trip; the answer comes later. Replaces the page's older request.

        Args:
            client: Page that gets the answer.
            trip: Message of the page.
            goal: Its destination.
            rider: Id of the rider, whose choices decide the order.
        """
        request = TripRequest(
            id=trip.id,
            client=client,
            goal=(goal.x, goal.y),
            rider=rider,
            wishes=wishes_of(trip.wishes),
        )
        if self._lost >= MAX_LOST:
            self._reject(request)
            return
        for replaced in [each for each in self._waiting if each.client == client]:
            self._reject(replaced)
        others = [each for each in self._waiting if each.client != client]
        self._waiting = deque([*others, request])
        if len(self._waiting) > MAX_QUEUED_PREVIEWS:
            self._reject(self._waiting.popleft())

    def set_planning_context(self, context: bytes) -> None:
        """Send the next request with a pickled context; empty: the navigator has none yet."""
        if not self._waiting or self._process is None or not context:
            return
        self._pending = replace(self._waiting.popleft(), planning_context=context)
        self._requested_at = time.monotonic()
        try:
            self._process.send(self._pending)
        except ProcessGone:
            self._lose()

    def start(self) -> None:
        """Start a missing process, unless too many have failed."""
        if self._process is None and self._lost < MAX_LOST:
            self._process = WorkerProcess(
                serve_previews, self._process_setup, "cohelm-previews", niceness=_NICENESS
            )

    def poll(self) -> None:
        """Pass an answer on to its page."""
        if self._process is None:
            return
        try:
            message = self._process.receive(0.0)
        except ProcessGone:
            self._lose()
            return
        if message is None and self._pending is not None:
            if time.monotonic() - self._requested_at > ANSWER_TIMEOUT:
                self._lose()
            return
        if isinstance(message, ProcessReady):
            self._ready = True
        if isinstance(message, TripPlans) and self._pending is not None:
            self._lost, self._requested_at = 0, time.monotonic()
            self._send(message, self._pending.client)
            self._pending = None if message.complete else self._pending

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.close()
        self._process, self._ready = None, False

    def _lose(self) -> None:
        """End a useless process and reject its request; after the last one reject all requests."""
        if self._process is not None:
            self._process.kill()
        self._process, self._ready = None, False
        self._lost += 1
        pending, self._pending = self._pending, None
        if pending is not None:
            self._reject(pending)
        if self._lost >= MAX_LOST:
            for request in self._waiting:
                self._reject(request)
            self._waiting.clear()

    def _reject(self, request: TripRequest) -> None:
        text = "The route could not be computed."
        self._send(Rejected(id=request.id, code="preview_failed", text=text), request.client)
