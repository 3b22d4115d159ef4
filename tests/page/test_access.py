"""WCAG 2.2 AA by axe-core on every view, in every palette; and what axe cannot see."""

from pathlib import Path

import pytest

AXE = Path(__file__).parents[2] / "page/node_modules/axe-core/axe.min.js"
TAGS = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
LOOK = """
async tags => {
  const rules = { "target-size": { enabled: true } };
  const found = await axe.run(document, { runOnly: [...tags], rules, resultTypes: ["violations"] });
  return found.violations.map(({ id, nodes }) => [id, nodes.slice(0, 4).map(({ html }) => html)]);
}
"""
PALETTES = {
    "light": {"color_scheme": "light", "contrast": "no-preference"},
    "dark": {"color_scheme": "dark", "contrast": "no-preference"},
    "contrast": {"color_scheme": "light", "contrast": "more"},
}
SIZES = {"phone": (360, 740), "tablet": (820, 1180), "desktop": (1280, 800)}
TARGETS = """
() => {
  const small = [];
  for (const each of document.querySelectorAll("button, a[href], input, select, summary")) {
    if (!each.checkVisibility({ visibilityProperty: true })) continue;
    const box = (each.closest("label") ?? each).getBoundingClientRect();
    const { width, height } = box;
    if (Math.min(width, height) < 43.5) small.push([each.outerHTML.slice(0, 90), width, height]);
  }
  return small;
}
"""
STOP = """
() => {
  const all = [...document.querySelectorAll("button")];
  const found = all.filter((each) => each.textContent.trim() === "STOP");
  const { x, y, width, height } = found[0].getBoundingClientRect();
  const [right, bottom] = [innerWidth - x - width, innerHeight - y - height];
  const inside = Math.min(x, y, right, bottom) >= -0.5;
  const top = document.elementFromPoint(x + width / 2, y + height / 2) === found[0];
  return { count: found.length, inside, top, least: Math.min(width, height) };
}
"""
CONTROLS = """
() => {
  const which = "button, a[href], input, select, summary, [tabindex='0']";
  const shown = (each) => each.checkVisibility({ visibilityProperty: true });
  window.controls = [...document.querySelectorAll(which)].filter(shown);
  window.controls = window.controls.filter((each) => !each.disabled && !each.closest("[inert]"));
  const groups = new Set();
  window.controls = window.controls.filter((each) => {
    if (each.type !== "radio") return true;
    if (groups.has(each.name) || !each.checked) return false;
    return groups.add(each.name);
  });
  document.activeElement.blur();
  return window.controls.length;
}
"""
AT = "() => window.controls.indexOf(document.activeElement)"


def page_of(riders, size, path="/", **options):
    width, height = SIZES[size]
    return riders(
        viewport={"width": width, "height": height}, bypass_csp=True, path=path,
        has_touch=size == "phone", **options,
    )  # fmt: skip


def panel(name):
    return lambda rider: rider.show(name)


def switches(rider):
    rider.show("Settings")
    rider.page.get_by_label("Two switches").check()


def overview(rider):
    """Of another trip, with what can be wished for."""
    rider.page.get_by_label("No switch").check()
    rider.look_at("Cafeteria")
    rider.press("Go via, avoid, draw…")
    rider.sees("Draw area to avoid")


def legend(rider):
    """Over the map, and the overview shut."""
    rider.press("Keep present trip")
    if rider.button("More map tools").count():  # on a low map
        rider.press("More map tools")
    rider.press("Legend")
    rider.sees("Person that the chair sees")


def spoken(rider):
    """Settings of cues, with speech."""
    rider.press("Close")  # of the legend, which may lie over its button
    rider.show("Settings")
    rider.page.get_by_label("Speak messages").check()


def german(rider):
    rider.press("Deutsch")
    rider.sees("Sprache")
    rider.press("English")


def point(rider):
    """A card over the map; on a phone the panel is shut for it."""
    rider.show("Go to")
    if rider.page.viewport_size["width"] < 600:
        rider.page.get_by_role("navigation").get_by_role("button", name="Go to").click()
    box = rider.page.locator("canvas").bounding_box()
    rider.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - 60)
    rider.sees("Avoid")


def wish(rider):
    """Into the overview of the trip under way."""
    rider.press("Avoid")
    rider.sees("Avoid this point")


def by_hand(rider):
    """The warning before the mode that can collide."""
    rider.who_steers()
    rider.page.get_by_role("button", name="Manual").click()
    rider.sees("In manual mode the chair does not stop by itself")


VIEWS = {
    "where": panel("Go to"),
    "speed": panel("Speed"),
    "mode": by_hand,
    "people": panel("Simulation"),
    "more": panel("Settings"),
    "switches": switches,
    "overview": overview,
    "legend": legend,
    "spoken": spoken,
    "german": german,
    "point": point,
    "wish": wish,
}


def faults(rider, palettes=tuple(PALETTES)):
    """What axe finds in each palette."""
    found = {}
    if not rider.page.evaluate("'axe' in window"):
        rider.page.evaluate(AXE.read_text())
    for name in palettes:
        rider.page.emulate_media(**PALETTES[name])
        rider.page.wait_for_function(
            "name => document.documentElement.dataset.palette === name", arg=name
        )
        if said := rider.page.evaluate(LOOK, TAGS):
            found[name] = said
    return found


def unreached(rider):
    """Controls that Tab does not come to, once round the page.

    Twice at most: a reason that changes meanwhile brings other controls.
    """
    return _unreached(rider) and _unreached(rider)


def _unreached(rider):
    count = rider.page.evaluate(CONTROLS)
    seen = set()
    for _ in range(count + 4):
        rider.page.keyboard.press("Tab")
        seen.add(rider.page.evaluate(AT))
    missed = set(range(count)) - seen
    return [rider.page.evaluate("k => controls[k].outerHTML", k) for k in missed]


@pytest.fixture(autouse=True, scope="module")
def axe():
    if not AXE.is_file():
        pytest.skip("needs axe-core: npm ci in page/")


@pytest.mark.parametrize(
    "size", [pytest.param(each, marks=[pytest.mark.slow] * (each == "desktop")) for each in SIZES]
)
def test_the_driver_s_page(riders, size):
    """Every panel and card: rules, targets, Tab; and STOP on top of it all."""
    rider = page_of(riders, size)
    rider.sees("No driver.")
    rider.aim("Ward 4")
    palettes = PALETTES if size != "tablet" else ["light"]
    for name, open_view in VIEWS.items():
        open_view(rider)
        assert faults(rider, palettes) == {}, name
        assert rider.page.evaluate(TARGETS) == [], name
        assert unreached(rider) == [], name
        stop = rider.page.evaluate(STOP)
        assert stop["least"] >= 72.0, name
        assert (stop["count"], stop["inside"], stop["top"]) == (1, True, True), name
        assert rider.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name


@pytest.mark.parametrize("size", SIZES)
def test_the_therapist_s_view(riders, chair, size):
    rider = page_of(riders, size, path="/therapist")
    rider.sees("Sign in as the therapist")
    assert faults(rider) == {}
    assert rider.page.evaluate(TARGETS) == []
    rider.page.get_by_label("Therapist’s token").fill(chair.token)
    rider.press("Sign in")
    rider.sees("Audit log")
    assert rider.page.evaluate(STOP)["least"] >= 72.0
    if rider.page.locator("summary").count():
        rider.page.locator("summary").first.click()
    assert faults(rider) == {}
    assert rider.page.evaluate(TARGETS) == []
    assert unreached(rider) == []
    assert rider.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    delete = rider.button("Delete all…")
    if delete.is_enabled():
        delete.click()
        assert faults(rider) == {}
        assert unreached(rider) == []
        rider.press("Cancel")


def test_signing_in_to_drive(riders):
    """As where a driver needs a token: the server's answers are stood in for."""
    rider = riders(bypass_csp=True)
    rider.page.route("**/api/me", lambda route: route.fulfill(status=401, json={}))
    rider.page.route_web_socket("**/ws", lambda socket: socket.close())
    rider.page.reload()
    rider.sees("Sign in to drive")
    assert faults(rider) == {}
    assert rider.page.evaluate(TARGETS) == []


def test_a_ride_by_keyboard_alone(rider):
    """From the first Tab to a chair that is on its way, and to STOP."""
    keyboard = rider.page.keyboard

    def tab_to(name):
        for _ in range(80):
            keyboard.press("Tab")
            if rider.page.evaluate("document.activeElement.textContent.trim()") == name:
                return
            label = rider.page.evaluate("document.activeElement.getAttribute('aria-label')")
            if label == name:
                return
        raise AssertionError(f"Tab does not come to {name}")

    tab_to("Drive from this screen")
    keyboard.press("Enter")
    state = rider.until(lambda state: rider.drives and state["link"] in {"ready", "confirm"})
    if state["link"] == "confirm":
        tab_to("Go on")
        keyboard.press("Enter")
    tab_to("Go to")
    keyboard.press("Enter")
    tab_to("Search for a place")
    keyboard.type("ward 4")
    keyboard.press("Enter")
    rider.until_button("Start")
    tab_to("Start")
    keyboard.press("Enter")
    rider.until(lambda state: state["goal"] and state["goal"]["name"] == "Ward 4")
    keyboard.press("Escape")
    rider.until(lambda state: state["link"] == "confirm")
    tab_to("Change route")
    keyboard.press("Enter")
    rider.until_button("Start this trip")
    tab_to("Keep present trip")
    keyboard.press("Enter")
    tab_to("Cancel trip")
    keyboard.press("Enter")
    rider.until(lambda state: state["goal"] is None)
