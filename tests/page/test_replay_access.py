"""WCAG 2.2 AA of a recorded ride's page, with its keyboard."""

import threading
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from cohelm.evaluation.episode.recorded import run_recorded
from cohelm.live.sessions.timeline import timeline_of_recording
from cohelm.scenarios import load_scenario
from cohelm.web.page_files import read_page
from cohelm.web.replay import replay_app, replay_server
from cohelm.web.server import listening

from .test_access import AXE, SIZES, TARGETS, faults, unreached


@pytest.fixture(scope="module")
def address(browser, tmp_path_factory):
    """Two seconds of a crossing, served with the built page."""
    file = tmp_path_factory.mktemp("replay") / "ride.mcap"
    run_recorded(load_scenario("crossing", ["people.count=3", "time_limit=2.0"]), 1, file)
    app = replay_app(timeline_of_recording(file), read_page(), "127.0.0.1")
    ready = threading.Event()
    with listening("127.0.0.1", 0) as bound:
        server = replay_server(app, ready.set)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]})
        thread.start()
        assert ready.wait(20.0)
        yield f"http://127.0.0.1:{bound.getsockname()[1]}"
        server.should_exit = True
        thread.join(20.0)


@pytest.mark.skipif(not AXE.is_file(), reason="needs axe-core: npm ci in page/")
@pytest.mark.parametrize("size", SIZES)
def test_a_recorded_ride(browser, address, size):
    width, height = SIZES[size]
    context = browser.new_context(viewport={"width": width, "height": height}, bypass_csp=True)
    rider = SimpleNamespace(page=context.new_page())
    rider.page.goto(address)
    slider = rider.page.get_by_role("slider", name="Time in the ride")
    expect(slider).to_be_visible(timeout=30_000)
    if rider.page.locator("summary").count():
        rider.page.locator("summary").first.click()
    assert faults(rider) == {}
    assert rider.page.evaluate(TARGETS) == []
    assert unreached(rider) == []
    assert rider.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    slider.focus()
    before = slider.get_attribute("aria-valuetext")
    rider.page.keyboard.press("End")
    expect(slider).not_to_have_attribute("aria-valuetext", before)
    context.close()


def test_a_recorded_ride_in_three_dimensions(browser, address):
    context = browser.new_context(viewport={"width": 1024, "height": 700})
    page = context.new_page()
    page.goto(address)
    page.get_by_role("button", name="3-D view").click(timeout=30_000)
    view = page.get_by_test_id("replay3d")
    expect(view).to_be_visible(timeout=30_000)
    behind = view.screenshot()
    page.get_by_role("button", name="From above").click()
    page.wait_for_timeout(2_000)
    assert view.screenshot() != behind
    assert page.get_by_role("alert").count() == 0
    page.get_by_role("button", name="3-D view").click()
    expect(view).to_have_count(0)
    context.close()
