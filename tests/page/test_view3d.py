"""The 3-D view in a Chromium that draws without a graphics card; and in one that cannot draw."""

from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import expect

from .conftest import CHROMIUM, FLAGS
from .rider import Rider
from .test_access import STOP, TARGETS, faults, unreached

IWER = Path(__file__).parents[2] / "page/node_modules/iwer/build/iwer.min.js"
SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SMALL = {"width": 800, "height": 600}
"""A third of the pixels of the page elsewhere: each of them is drawn by software."""
COUNT = """
window.draws = 0;
for (const name of ["drawElements", "drawElementsInstanced"]) {
  const draw = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...all) {
    window.draws += 1;
    return draw.apply(this, all);
  };
}
"""
LOSE = """() => {
  window.taken = document.querySelector("canvas").getContext("webgl2")
    .getExtension("WEBGL_lose_context");
  window.taken.loseContext();
}"""
HEADSET = """
const device = new IWER.XRDevice(IWER.metaQuest3);
device.installRuntime({ forceInstall: true });
"""


@pytest.fixture(scope="module")
def drawing(browser):
    """A browser with WebGL by software; the other one has none."""
    engine = browser.browser_type
    made = engine.launch(executable_path=str(CHROMIUM), args=[*FLAGS, *SOFTWARE])
    yield made
    made.close()


@pytest.fixture
def open_view(drawing, chair):
    """Opens a page with the 3-D view."""
    opened = []

    def open_page(before="", **options):
        rider = Rider(drawing, chair, before=COUNT + before, **{"viewport": SMALL, **options})
        opened.append(rider)
        rider.sees("No driver.")
        rider.press("More map tools")  # the map is low
        rider.press("3-D view")
        expect(rider.button("From behind")).to_be_visible(timeout=60_000)
        return rider

    yield open_page
    for rider in opened:
        rider.close()
    assert [fault for rider in opened for fault in rider.faults] == []


def draws(rider):
    """Check that something is drawn within a second."""
    before = rider.page.evaluate("window.draws")
    rider.page.wait_for_function("before => window.draws > before", arg=before)
    return True


def test_opens_draws_changes_its_camera_and_closes(open_view):
    rider = open_view()
    assert draws(rider)
    for camera in ("From above", "Rider’s eyes", "From behind"):
        rider.press(camera)
        assert rider.button(camera).get_attribute("aria-pressed") == "true"
        assert draws(rider)
    words = rider.page.locator("#view3d-words").inner_text()
    assert "The chair stands" in words
    expect(rider.button("Enter headset")).to_have_count(0)  # there is none
    rider.press("3-D view")
    expect(rider.page.get_by_test_id("view3d")).to_have_count(0)
    expect(rider.page.get_by_role("img", name="Map of the floor").locator("canvas")).to_be_visible()


@pytest.mark.slow
def test_closing_gives_the_graphics_memory_back(open_view):
    """A browser takes the oldest of more than 16 contexts away, and says so."""
    rider = open_view()
    said = []
    rider.page.on("console", lambda message: said.append(message.text))
    for _ in range(18):
        rider.press("3-D view")
        rider.press("3-D view")
        expect(rider.button("From behind")).to_be_visible(timeout=60_000)
    assert [text for text in said if "context" in text.lower() and "Too many" in text] == []


def test_with_less_motion_it_begins_above_stop_is_on_top_and_axe_finds_nothing(open_view):
    rider = open_view(bypass_csp=True, reduced_motion="reduce")
    assert rider.button("From above").get_attribute("aria-pressed") == "true"
    assert faults(rider) == {}
    assert rider.page.evaluate(TARGETS) == []
    assert unreached(rider) == []
    stop = rider.page.evaluate(STOP)
    assert (stop["count"], stop["inside"], stop["top"]) == (1, True, True)


def test_beside_a_driving_chair_it_waits_until_the_chair_stands(drawing, chair):
    """Building it takes longer than a heartbeat may be late."""
    for _ in range(3):
        since = chair.state["clock"]
        with closing(Rider(drawing, chair, viewport=SMALL)) as rider:
            rider.take()
            rider.press("More map tools")
            rider.hold()
            rider.press("3-D view")
            rider.rest(1.0)
            told = rider.page.get_by_text("The 3-D view opens as soon as the chair stands.")
            waits = told.count() == 1 and rider.button("From behind").count() == 0
            late = rider.fell_behind(since)
            rider.let_go()
            expect(rider.button("From behind")).to_be_visible(timeout=60_000)
            assert rider.faults == []
        if waits or not late:  # a chair whose navigator fell behind stands
            break
    assert waits


@pytest.mark.slow
def test_a_lost_context_is_told_and_comes_back(open_view):
    rider = open_view()
    rider.page.evaluate(LOSE)
    rider.sees("The graphics card took the 3-D view away")
    rider.page.evaluate("window.taken.restoreContext()")
    expect(rider.page.get_by_text("The graphics card took the 3-D view away")).to_have_count(0)
    assert draws(rider)


def test_without_webgl_the_map_stays_and_says_why(riders):
    rider = riders(before="HTMLCanvasElement.prototype.getContext = ((get) => function (kind, o) {"
                          " return kind === 'webgl2' ? null : get.call(this, kind, o); })"
                          "(HTMLCanvasElement.prototype.getContext);")  # fmt: skip
    rider.sees("No driver.")
    rider.press("3-D view")
    rider.sees("This browser cannot draw in 3-D")
    expect(rider.page.get_by_role("img", name="Map of the floor").locator("canvas")).to_be_visible()
    rider.press("Close")
    expect(rider.page.get_by_text("This browser cannot draw in 3-D")).to_have_count(0)


@pytest.mark.skipif(not IWER.is_file(), reason="needs iwer: npm ci in page/")
def test_a_headset_is_entered_and_drawn_in(open_view):
    rider = open_view(before=IWER.read_text() + HEADSET)
    expect(rider.button("Enter headset")).to_be_visible()
    rider.page.evaluate("""() => {
      const ask = navigator.xr.requestSession.bind(navigator.xr);
      navigator.xr.requestSession = async (...all) => (window.worn = await ask(...all));
    }""")
    rider.press("Enter headset")
    rider.page.wait_for_function("window.worn !== undefined")
    assert draws(rider)
    rider.page.evaluate("window.worn.end()")
    assert draws(rider)
