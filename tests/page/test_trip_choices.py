"""Where to, which way, who steers and how fast: chosen on the page, done by the chair."""

import math
import re

from playwright.sync_api import expect

from .served import held, moves, stands

MARGIN = 16  # px, about the whole floor


def pixel(rider, x, y):
    """Of a point on a map that shows the whole floor: in its middle, as large as fits."""
    floor = rider.chair.scene["floor"]
    size = floor["width"] * floor["resolution"], floor["height"] * floor["resolution"]
    box = rider.page.locator("canvas").bounding_box()
    tools = rider.page.get_by_role("group", name="Map", exact=True).bounding_box()
    box["width"] -= tools["width"] + MARGIN  # the floor lies beside them
    scale = min((box["width"] - 2 * MARGIN) / size[0], (box["height"] - 2 * MARGIN) / size[1])
    across = box["x"] + box["width"] / 2 + scale * (x - floor["x"] - size[0] / 2)
    return across, box["y"] + box["height"] / 2 - scale * (y - floor["y"] - size[1] / 2)


def test_a_destination_chosen_by_its_name_is_driven_to(rider):
    rider.take()
    began = rider.follow("Ward 4")
    rider.sees("Going to")
    rider.sees("m left")
    began = rider.makes(moves, lambda: None)
    later = rider.makes(lambda state: state["remaining"] < began["remaining"] - 0.3, lambda: None)
    assert later["goal"]["name"] == "Ward 4"
    rider.press("Cancel trip")
    rider.until(lambda state: state["goal"] is None and stands(state))


def test_a_destination_is_chosen_on_the_map(rider, chair):
    """Two metres north of the chair, where the hall is free."""
    x, y, _ = chair.state["pose"]
    rider.press("Whole floor")
    rider.page.mouse.click(*pixel(rider, x, y + 2.0))
    rider.press("Go here")
    rider.press("Start")
    goal = rider.until(lambda state: state["goal"])["goal"]
    assert math.dist((goal["x"], goal["y"]), (x, y + 2.0)) < 0.3


def test_the_chair_drives_nowhere_while_nobody_drives(rider):
    rider.aim("Ward 4")
    rider.holds(held, 1.0)


def test_a_destination_is_offered_for_the_stick_and_chosen_by_one_key_press(rider):
    rider.take()
    rider.hold("ArrowUp", lambda state: state["offers"])
    rider.let_go("ArrowUp")
    state = rider.until(lambda state: state["offers"] and stands(state))
    assert state["goal"] is None  # an offer alone is no destination
    rider.go_on()
    card = rider.page.get_by_role("group", name="Suggested destinations")
    first = card.get_by_role("button").first
    name, why = re.match(r"To (.+)\? (.+)", " ".join(first.inner_text().split())).groups()
    assert why in {each["why"] for each in rider.chair.state["offers"]}
    first.focus()
    rider.page.keyboard.press("Enter")
    expect(card).to_have_count(0)
    assert chair_goal(rider) is None  # neither is the overview
    rider.press("Start")
    rider.until(lambda state: state["goal"] and state["goal"]["name"] == name)


def chair_goal(rider):
    return rider.chair.state["goal"]


def nearest(points, place):
    return min(math.dist(point, place) for point in points)


def ways(chair, law):
    """The newest of the routes that were told, once it fulfils a law."""

    def newest(told):
        routes = [each for each in [*chair.told] if each["type"] == "route"]
        return told is routes[-1] and law(told) if routes else False

    return chair.heard(newest)


def test_a_wish_is_priced_confirmed_heeded_and_taken_back(rider, chair):
    """The way to Ward 4 leads through the north; by the laboratory it is another, longer one."""
    at = {place["name"]: (place["x"], place["y"]) for place in chair.scene["places"]}
    rider.aim("Ward 4")
    before = ways(chair, lambda way: way["points"])
    far = nearest(before["points"], at["Laboratory"])

    rider.press("Change route")
    rider.press("Go via, avoid, draw…")
    rider.page.get_by_label("Choose a place").select_option("Laboratory")
    rider.press("Go via here")
    told = rider.page.get_by_text(re.compile(r"^By way of Laboratory: \+[\d.]+ m\.$"))
    expect(told).to_be_visible(timeout=32_000)
    price = float(re.search(r"\+([\d.]+)", told.inner_text())[1])
    assert chair.state["route_version"] == before["version"]  # so far it is a question only

    rider.until_button("Start this trip")
    rider.press("Start this trip")
    after = ways(chair, lambda way: way["wishes"] and way["extra_length"] > 0.0)
    assert nearest(after["points"], at["Laboratory"]) < 0.5 < far
    assert after["length"] > before["length"]
    assert abs(price - (after["length"] - before["length"])) < 0.5
    assert after["without_wishes"]

    rider.press("STOP")
    rider.press("Change route")
    rider.press("Remove: Go via Laboratory")
    rider.until_button("Start this trip")
    rider.press("Start this trip")
    again = ways(chair, lambda way: not way["wishes"])
    assert nearest(again["points"], at["Laboratory"]) > 0.5


def test_a_line_drawn_across_the_way_is_avoided(rider, chair):
    rider.aim("Ward 4")
    before = ways(chair, lambda way: way["points"])
    rider.press("Change route")
    rider.press("Go via, avoid, draw…")
    rider.press("Draw area to avoid")
    rider.press("Whole floor")
    x, y = before["points"][len(before["points"]) // 2]
    draw(rider, [(x - 0.3, y - 2.0), (x + 0.3, y + 2.0)])
    rider.until_button("Start this trip")
    rider.press("Start this trip")
    after = ways(chair, lambda way: way["wishes"])
    assert after["wishes"][0]["kind"] == "avoid"
    assert after["extra_length"] > 0.0


def draw(rider, line):
    """With the mouse, on the whole floor."""
    for k, at in enumerate(line):
        rider.page.mouse.move(*pixel(rider, *at), steps=6)
        if k == 0:
            rider.page.mouse.down()
    rider.page.mouse.up()


def test_who_steers_and_how_fast(rider):
    rider.take()
    rider.who_steers()
    rider.press(re.compile("^Assisted"))
    rider.until(lambda state: state["mode"] == "assisted")
    rider.press(re.compile("^Manual"))
    rider.sees("In manual mode the chair does not stop by itself")
    rider.holds(lambda state: state["mode"] == "assisted", 0.3)
    rider.press("Use Manual")
    rider.until(lambda state: state["mode"] == "manual")
    rider.show("Speed")
    rider.press(re.compile("^Slow"))
    rider.until(lambda state: state["pace"] == "slow")


def test_a_ride_can_be_rated_after_it(rider):
    rider.take()
    began = rider.follow()["remaining"]
    rider.makes(lambda state: state["remaining"] < began - 2.0, lambda: None)
    rider.who_steers()
    rider.press("Stop driving from this screen")
    rider.sees("Rate this ride (optional)")
    rider.press("4 of 5, good")
    rider.sees("Thank you.")


def test_somebody_comes_a_door_shuts_and_all_begins_anew(rider, chair):
    rider.show("Simulation")
    people = len(chair.state["true_people"])
    rider.press("Add a person")
    rider.until(lambda state: len(state["true_people"]) == people + 1)
    rider.press(re.compile("^3\\. .*: open$"))
    rider.until(lambda state: state["closed_doors"] == [2])
    rider.press("Pause")
    rider.until(lambda state: state["paused"])
    rider.page.get_by_label("Seed").fill("3")
    rider.press("Restart")
    rider.sees("The simulation has restarted with seed 3.")
    rider.until(lambda state: not state["closed_doors"] and len(state["true_people"]) == people)
