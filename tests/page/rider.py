"""Somebody at the page: what they press, and when the page last said that it is alive."""

import json
import os
import re
import time
from contextlib import suppress

from playwright.sync_api import Error, expect

from .cable import Cable
from .served import brief, wants

PATIENCE = 30_000  # ms: on a busy machine a page takes its time
START = re.compile("^(Start|Start this trip|Change to this trip)$")
LEAVE = re.compile("^(Cancel trip|Keep present trip)$")
GO_ON = re.compile("^Go on( to .*)?$")
PADS = """
window.pads = [];
navigator.getGamepads = () => window.pads;
window.pad = (forward, left, down = []) => (window.pads = [{
  index: 0, id: "pad", connected: true, mapping: "standard", timestamp: performance.now(),
  axes: [-left, -forward, 0, 0],
  buttons: Array.from({ length: 17 }, (_, n) => ({ pressed: down.includes(n), value: 0 })),
}]);
"""


class Rider:
    """A page in a context of its own, at the other end of a cable of its own."""

    def __init__(self, browser, chair, path="/", before="", context=None, **options):
        self.chair = chair
        self.cable = Cable(chair.port)
        self._own = context is None
        before_it = renderers(browser)
        self.context = context or browser.new_context(**options)
        self.context.set_default_timeout(PATIENCE)
        self.page = self.context.new_page()
        self.page.add_init_script(PADS + before)
        self.faults, self.beats, self.client = [], {}, None
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("websocket", self._listen)
        self.address = f"http://127.0.0.1:{self.cable.port}"
        self.page.goto(self.address + path)
        self._renderers = renderers(browser) - before_it
        self._epoch = time.time() - time.monotonic()
        self._began = self.page.evaluate("performance.timeOrigin") / 1000.0

    def _listen(self, socket):
        """To one of the page's connections: under which name, and which beats it sends."""
        sent = []

        def received(text):
            if text.startswith('{"type":"welcome"'):
                self.client = json.loads(text)["client"]
                self.beats[self.client] = sent

        socket.on("framesent", lambda text: '"heartbeat"' in text and sent.append(json.loads(text)))
        socket.on("framereceived", received)

    def close(self):
        with suppress(Error):
            self.page.close()
        if self._own:
            self.context.close()
        self.cable.close()

    def signal(self, what):
        """To the processes that show the page, as far as they are there."""
        for pid in self._renderers:
            with suppress(ProcessLookupError):
                os.kill(pid, what)

    # What they do

    def button(self, name):
        return self.page.get_by_role("button", name=name, exact=isinstance(name, str))

    def press(self, name):
        self.button(name).click()

    def rest(self, seconds):
        self.page.wait_for_timeout(1000.0 * seconds)

    def sees(self, text):
        expect(self.page.get_by_text(text).filter(visible=True).first).to_be_visible(
            timeout=PATIENCE
        )

    def until(self, law, within=20.0):
        """The chair's state once it fulfils a law."""
        return self.chair.until(law, within, self.rest)

    def holds(self, law, seconds=0.6):
        """A law holds of every state for a while."""
        since = self.chair.state["clock"]
        self.rest(seconds)
        found = [each for each in [*self.chair.states] if each["clock"] > since]
        against = [brief(each) for each in found if not law(each)]
        assert found
        assert not against, f"{len(against)} of {len(found)}, {against[:1]}"

    @property
    def drives(self):
        return self.client is not None and self.chair.state.get("driver") == self.client

    def take(self):
        """Drive from this page, with nothing held, and go on if that must be said."""
        self.press("Drive from this screen")
        self.until(lambda state: self.drives and state["link"] in {"ready", "confirm"})
        self.go_on()

    def go_on(self):
        """Say so, if it must be said; on a busy machine more than once."""
        for _ in range(10):
            state = self.until(lambda state: state["link"] in {"ready", "confirm"})
            if state["link"] == "ready":
                return
            with suppress(Error):  # the button goes where the chair falls behind meanwhile
                self.button(GO_ON).click(timeout=3000)
            self.rest(0.2)

    def makes(self, law, act, undo=lambda: None):
        """Do something that the chair follows, and wait until it does.

        A chair whose navigator fell behind stands, says so and waits for "Go on". Only then, as a
        rider would, the action is repeated; an action without effect is a failure.
        """
        for _ in range(5):
            act()
            state = self.until(lambda state: law(state) or _fell_behind(state))
            if law(state):
                return state
            undo()
            self.go_on()
        raise AssertionError(f"the navigator keeps falling behind: {brief(self.chair.state)}")

    def fell_behind(self, since):
        """Whether the chair stood after ``since`` because its navigator was late."""
        found = [each for each in [*self.chair.states] if each["clock"] >= since]
        return any(_late(each) for each in found)

    def leave_fields(self):
        """So that keys are nobody's but the chair's."""
        self.page.evaluate("document.activeElement.blur()")

    def hold(self, key="ArrowLeft", law=wants):
        """Hold a key until the chair obeys; to the left there is always room."""
        self.leave_fields()
        return self.makes(law, lambda: self.page.keyboard.down(key), lambda: self.let_go(key))

    def let_go(self, key="ArrowLeft"):
        self.page.keyboard.up(key)

    def look_at(self, place):
        """Choose a place by its name, and wait for the overview of the trip."""
        self.show("Go to")
        overview = self.page.get_by_role("group", name="Trip", exact=True)
        if overview.count():  # of another trip, in the place of the list
            overview.get_by_role("button", name=LEAVE).click()
        field = self.page.get_by_role("searchbox", name="Search for a place")
        field.fill(place.lower())
        field.press("Enter")
        self.until_button(START)

    def choose(self, place):
        """Start a trip to a place; takes control where nobody has it."""
        self.look_at(place)
        self.button(START).click()
        return self.until(lambda state: state["goal"] and state["goal"]["name"] == place)

    def until_button(self, name):
        """A button that may be pressed."""
        expect(self.button(name)).to_have_attribute("aria-disabled", "false", timeout=PATIENCE)

    def aim(self, place):
        """Set the destination of a chair that nobody drives, so that it stands."""
        self.chair.say("set_goal", place=place)
        return self.until(lambda state: state["goal"] and state["goal"]["name"] == place)

    def follow(self, place="Ward 4"):
        """Choose where to go, and wait until the chair is on its way."""
        return self.makes(wants, lambda: self.choose(place))

    def show(self, panel):
        """Open a panel, if it is not."""
        tab = self.page.get_by_role("navigation").get_by_role("button", name=panel, exact=True)
        if tab.get_attribute("aria-expanded") != "true":
            tab.click()

    def who_steers(self):
        """Open the choice of the mode, if it is not."""
        header = self.page.get_by_role("button", name=re.compile("^Mode: "))
        if header.get_attribute("aria-expanded") != "true":
            header.click()

    # What the chair hears of it

    def told_last(self, before):
        """When the last beat that the chair heeded ``before`` was sent; by ``time.monotonic``."""
        states = [each for each in [*self.chair.states] if each["clock"] < before]
        heeded = [each for each in states if each["heartbeat"] >= 0]
        last = next(each for each in reversed(heeded) if each["driver"] in self.beats)
        beats, limit = self.beats[last["driver"]], time.monotonic() + PATIENCE / 1000.0
        while not (sent := [each["sent"] for each in beats if each["seq"] == last["heartbeat"]]):
            assert time.monotonic() < limit, "no beat is known that the chair heeded"
            self.rest(0.1)  # the browser may tell of it later than the chair
        return self._began + sent[-1] / 1000.0 - self._epoch


def renderers(browser):
    """Pids of the processes that show pages."""
    session = browser.new_browser_cdp_session()
    found = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return {each["id"] for each in found if each["type"] == "renderer"}


def _late(state):
    return bool(state["reason"]) and state["reason"]["code"] == "navigator_timeout"


def _fell_behind(state):
    return _late(state) and state["link"] != "ready"
