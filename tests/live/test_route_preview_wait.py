"""The routes of a trip are waited for, but not for ever."""

import pytest

from cohelm.live.control.ipc import ProcessReady
from cohelm.live.control.worker_process import ProcessGone
from cohelm.live.messages import Destination, PlanTrip, TripPlans
from cohelm.live.page import route_preview


def ask(previews, client, number):
    trip = PlanTrip(id=number, point=(1.0, 2.0))
    previews.request(client, trip, Destination(name="", x=1.0, y=2.0), "")


class Mute:
    """A process that is ready and then says nothing more."""

    made = 0

    def __init__(self, *_, **__):
        Mute.made += 1
        self.says = [ProcessReady(done=True)]

    def receive(self, timeout):
        return self.says.pop() if self.says else None

    def send(self, message):
        pass

    def kill(self):
        pass


@pytest.mark.parametrize(("patience", "refused"), [(-1.0, 1), (1e9, 0)])
def test_a_process_that_hangs_is_begun_anew_and_its_question_refused(
    monkeypatch, patience, refused
):
    monkeypatch.setattr(route_preview, "WorkerProcess", Mute)
    monkeypatch.setattr(route_preview, "ANSWER_TIMEOUT", patience)
    told, made = [], Mute.made
    asked = route_preview.RoutePreview(
        None, lambda message, client: told.append((message.code, client))
    )
    asked.start()
    asked.poll()
    ask(asked, "a", 3)
    assert asked.needs_context
    asked.set_planning_context(b"about")
    asked.poll()
    asked.start()
    assert told == refused * [("preview_failed", "a")]
    assert Mute.made - made == 1 + refused


def test_after_the_last_process_every_request_is_answered(monkeypatch):
    monkeypatch.setattr(route_preview, "WorkerProcess", Mute)
    monkeypatch.setattr(route_preview, "ANSWER_TIMEOUT", -1.0)
    told = []
    asked = route_preview.RoutePreview(None, lambda message, client: told.append(client))
    for lost in range(route_preview.MAX_LOST):
        asked.start()
        asked.poll()
        clients = ["a", "b", "c"] if lost == route_preview.MAX_LOST - 1 else ["a"]
        for client in clients:
            ask(asked, client, lost)
        asked.set_planning_context(b"about")
        asked.poll()
    assert told == ["a"] * route_preview.MAX_LOST + ["b", "c"]
    assert not asked.needs_context


class AnswersThenDies(Mute):
    """A process that answers one request and is then lost."""

    def __init__(self, *_, **__):
        super().__init__()
        self.asked = None

    def receive(self, timeout):
        if self.says:
            return self.says.pop()
        if self.asked is None:
            raise ProcessGone
        answer = TripPlans(id=self.asked.id)
        self.asked = None
        return answer

    def send(self, message):
        self.asked = message


def test_lost_processes_that_answered_before_are_replaced_for_ever(monkeypatch):
    """A long day loses more than ``MAX_LOST``; only those in a row tell that none will work."""
    monkeypatch.setattr(route_preview, "WorkerProcess", AnswersThenDies)
    told = []
    asked = route_preview.RoutePreview(None, lambda message, client: told.append(message))
    for number in range(3 * route_preview.MAX_LOST):
        asked.start()
        asked.poll()  # ready
        ask(asked, "a", number)
        asked.set_planning_context(b"about")
        asked.poll()  # the answer
        asked.poll()  # lost
    assert [message.type for message in told] == ["trip_plans"] * 3 * route_preview.MAX_LOST
    for _ in range(route_preview.MAX_LOST):
        asked.start()
        asked.poll()  # ready
        asked.poll()  # lost without an answer
    ask(asked, "a", 99)
    assert told[-1].type == "rejected"
