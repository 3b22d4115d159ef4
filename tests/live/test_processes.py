"""Processes of a drive: they end quietly with their owner, and with a traceback otherwise."""

import os
from types import SimpleNamespace

import pytest

from cohelm.live.control import navigator_process, owner_pipe
from cohelm.live.control.ipc import ProcessReady, ProcessSetup
from cohelm.live.control.worker_process import WorkerProcess
from cohelm.live.control.world_factory import WorldError
from cohelm.live.page import preview_process


class Pipe:
    """A pipe with one request, after which the owner has gone."""

    def __init__(self):
        self.sent, self.requests = [], [SimpleNamespace(step_id=1, rider="", load_routes=False)]

    def send(self, message):
        self.sent.append(message)

    def recv(self):
        if not self.requests:
            raise EOFError
        return self.requests.pop()


def full_disk(*_):
    raise OSError(28, "No space left on device")


@pytest.fixture(params=["navigator", "previews"])
def served(request, monkeypatch):
    """The main function of a process, and where its work is done."""
    module = navigator_process if request.param == "navigator" else preview_process
    for name in ("leave_interrupts", "end_with_owner", "build_again", "_warm_up", "warm_up"):
        monkeypatch.setattr(module, name, lambda *_, **__: (), raising=False)
    if module is preview_process:
        return module.serve_previews, lambda work: monkeypatch.setattr(
            module, "trip_answers", lambda *_: iter([work()])
        )
    server = SimpleNamespace(answer=lambda _: "answer", record=lambda *_: None, close=lambda: None)
    monkeypatch.setattr(module, "NavigatorServer", lambda *_: server)
    monkeypatch.setattr(module, "gc", SimpleNamespace(collect=len, freeze=list, disable=list))
    module.gc.collect = lambda *_: 0
    return module.serve_navigator, lambda work: setattr(server, "answer", work)


def test_it_ends_quietly_once_its_owner_is_gone(served):
    serve, works = served
    works(lambda *_: "answer")
    pipe = Pipe()
    serve(pipe, ProcessSetup(scenario=None, seed=0))
    assert pipe.sent == [ProcessReady(done=True), "answer"]


def test_a_fault_of_its_own_is_not_taken_for_the_end_of_its_owner(served):
    """An OSError of its work, as of a full disk, looks like one of the pipe."""
    serve, works = served
    works(full_disk)
    with pytest.raises(OSError, match="No space left"):
        serve(Pipe(), ProcessSetup(scenario=None, seed=0))


def test_a_ride_that_cannot_be_built_is_left_to_the_owner_to_report(monkeypatch):
    def refused(*_):
        raise WorldError("the goal lies in a wall")

    monkeypatch.setattr(owner_pipe, "build_scenario", refused)
    monkeypatch.setattr(preview_process, "leave_interrupts", lambda: None)
    monkeypatch.setattr(preview_process, "end_with_owner", lambda: None)
    pipe = Pipe()
    preview_process.serve_previews(pipe, ProcessSetup(scenario=None, seed=0))
    assert pipe.sent == []


def tell_priority(pipe, _):
    pipe.send(os.getpriority(os.PRIO_PROCESS, 0))


def test_a_process_of_low_priority_has_it_before_it_imports_the_program():
    """Not only once it works: to import takes seconds, and the chair may drive meanwhile."""
    own = os.getpriority(os.PRIO_PROCESS, 0)
    more = min(7, 19 - own)
    process = WorkerProcess(tell_priority, None, "low", niceness=more)
    try:
        assert os.getpriority(os.PRIO_PROCESS, process.pid) == own + more
        assert process.receive(60.0) == own + more
    finally:
        process.close()
    assert os.getpriority(os.PRIO_PROCESS, 0) == own
