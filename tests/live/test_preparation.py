"""A first start: pages see how far the compilation is, and the stick drives before routes do."""

import time
from types import SimpleNamespace

import pytest

from cohelm.live import compilation
from cohelm.live.control.ipc import CompileStatus
from cohelm.live.control.step_timing import STEP
from cohelm.live.messages import Preparing, SetGoal
from cohelm.live.preparation import Preparation
from cohelm.platforms import PlanarPlatform
from cohelm.reasons import Reason
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Hidden, Rig
from .test_loop import Stand, made_loop


def compiles(pipe, _):
    pipe.send(CompileStatus(share=0.5, left=60.0))
    pipe.send(CompileStatus(share=0.8, left=20.0, steerable=True))
    pipe.recv()
    pipe.send(CompileStatus(share=1.0, steerable=True, done=True))


def fails(pipe, _):
    raise SystemExit(3)


@pytest.fixture
def started(request, monkeypatch):
    monkeypatch.setattr(compilation, "serve_compilation", request.param)
    made = Preparation(early=True)
    process = made._process
    yield made
    made.close()
    process.close()  # what is done, or has failed, ends by itself


def until(made, holds):
    end = time.monotonic() + 60.0
    while not holds(made):
        assert time.monotonic() < end
        made.poll()
        time.sleep(0.01)


@pytest.mark.parametrize("started", [compiles], indirect=True)
def test_the_stick_is_ready_before_routes(started):
    assert not started.steerable
    until(started, lambda made: made.steerable)
    assert started.status == CompileStatus(share=0.8, left=20.0, steerable=True)
    started._early = False  # a real chair waits for all of it
    assert not started.steerable
    started._process.send("go on")
    until(started, lambda made: made.status.done)
    assert started.steerable


@pytest.mark.parametrize("started", [fails], indirect=True)
def test_a_compilation_that_fails_holds_nobody_up(started):
    until(started, lambda made: made.status.done)
    assert started.steerable


@pytest.fixture
def rig():
    rig = Rig(build_scenario(load_scenario("empty"), 0))
    rig.navigator.routes = False
    rig.cycle.preparing = Preparing(share=0.9)
    return rig


def test_routes_are_loaded_once_the_chair_stands_and_nobody_steers(rig):
    rig.drive()
    assert rig.steps(14, 0.8)[-1].speed > 0.1  # the stick drives meanwhile
    rig.cycle.load_routes = True
    rig.steps(6, 0.8)
    assert not any(request.load_routes for request in rig.navigator.requests)
    rig.steps(40, 0.0)
    assert [request.load_routes for request in rig.navigator.requests].count(True) == 1
    assert rig.navigator.routes
    assert rig.state.reason is None


def test_the_chair_stands_and_says_so_while_routes_are_loaded(rig):
    rig.drive()
    rig.cycle.load_routes, rig.navigator.takes = True, 2.0
    rig.steps(5, 0.0)
    rig.navigator.takes = 0.012  # all later answers
    assert rig.steps(20, 0.0)[-1].reason.code == Reason.STARTING.value
    assert not rig.state.can_plan
    rig.steps(30, 0.0)
    assert (rig.state.reason, rig.state.can_plan, rig.state.link) == (None, True, "ready")


@pytest.mark.parametrize(("platform", "takes"), [(PlanarPlatform, 7.0), (Hidden, 2.0)])
def test_a_stick_held_meanwhile_must_be_centred_first(platform, takes):
    """However long it takes, the driver need not confirm, and STOP stays STOP."""
    rig = Rig(build_scenario(load_scenario("empty"), 0), platform)
    rig.drive()
    rig.navigator.routes, rig.cycle.load_routes, rig.navigator.takes = False, True, takes
    rig.steps(5, 0.0)
    rig.navigator.takes = 0.012
    held = rig.steps(round(takes / STEP) + 20, 0.8)
    assert rig.navigator.routes
    assert all(state.command == (0.0, 0.0) for state in held)
    assert held[-1].link == "centre_stick"
    rig.steps(6, 0.0)
    assert rig.steps(14, 0.8)[-1].command[0] > 0.0


def test_a_stick_that_rests_beside_its_centre_delays_nothing(rig):
    rig.drive()
    rig.cycle.load_routes = True
    rig.steps(10, 0.02)
    assert rig.navigator.routes


def test_a_navigator_that_is_lost_meanwhile_is_not_waited_for(rig):
    rig.drive()
    rig.cycle.load_routes, rig.navigator.takes = True, 2.0
    rig.steps(5, 0.0)
    assert rig.cycle.state.loading_routes >= 0
    rig.cycle.navigator_restarted()
    assert rig.cycle.state.loading_routes == -1


def test_no_destination_is_taken_before_there_are_routes(rig):
    rig.commands._loop = SimpleNamespace(preparing=True)
    rig.say(SetGoal(id=3, point=(5.0, 5.0)))
    rig.step()
    assert [(told.code, told.id) for told in rig.of("rejected")] == [("not_now", 3)]
    assert rig.state.goal is None


def test_a_loop_prepares_until_its_navigator_has_the_routes():
    loop = made_loop(Stand(), None)
    navigator = loop._navigator
    compiled = SimpleNamespace(poll=lambda: None, status=CompileStatus(share=0.5), steerable=False)
    compiled.close, loop._preparation = lambda: None, compiled
    asked = []
    navigator.supervise = lambda now, routes: asked.append(routes)
    loop._supervise(0.0)
    assert (asked, loop.cycle.preparing) == ([], Preparing(share=0.5))
    compiled.steerable, navigator.routes = True, False
    loop._supervise(0.1)
    assert asked == [False]
    navigator.ready, compiled.status = True, CompileStatus(share=1.0, steerable=True, done=True)
    loop._supervise(0.2)
    assert loop.cycle.load_routes
    assert loop.preparing
    navigator.routes = True
    loop._supervise(0.3)
    assert not loop.preparing
    assert loop.cycle.preparing is None
