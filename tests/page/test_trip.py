"""A trip from the choice to the arrival: overview, one button, what is told on the way."""

import re
from contextlib import suppress

import pytest
from playwright.sync_api import expect

from .served import moves, stands
from .test_trip_choices import nearest, pixel, ways

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True}


def has_begun(state):
    """Nothing is left to confirm, but a connection that a busy machine has lost since."""
    reason = state["reason"]
    return state["link"] == "ready" or (reason and reason["code"] == "connection_lost")


def test_nothing_sets_off_before_start_and_the_whole_route_is_seen(rider, chair):
    rider.look_at("Cafeteria")
    rider.sees(re.compile(r"^about \d+ (s|min)$"))
    rider.holds(lambda state: state["goal"] is None)
    expect(rider.button("Overview of the whole route")).to_have_attribute("aria-pressed", "true")
    rider.press("Start")  # the only press: it takes control, too
    rider.until(lambda state: rider.drives and state["goal"] and has_begun(state))
    rider.makes(moves, rider.go_on)
    panel = rider.page.get_by_role("region", name="Your trip")
    expect(panel).to_contain_text(re.compile(r"(Turn (left|right)|Straight on)"))
    expect(panel).to_contain_text("Cafeteria")
    assert rider.page.get_by_role("button", name="Pharmacy").count() == 0  # places are away
    rider.press("Cancel trip")
    rider.until(lambda state: state["goal"] is None and stands(state))


def test_an_alternative_is_driven_if_it_is_chosen(rider, chair):
    """To the cafeteria there is the south corridor, and a longer way round by the north."""
    rider.look_at("Cafeteria")
    second = rider.page.get_by_role(
        "button", name=re.compile(r"through North corridor, about \d+ s longer")
    )
    expect(second).to_have_count(1, timeout=60_000)  # it joins the first route
    second.click()
    rider.press("Start")
    way = ways(chair, lambda way: way["points"] and way["length"] > 36.0)
    at = {place["name"]: (place["x"], place["y"]) for place in chair.scene["places"]}
    assert nearest(way["points"], at["North corridor"]) < 3.0
    assert way["wishes"]


def test_a_trip_by_way_of_the_laboratory(rider, chair):
    rider.look_at("Ward 4")
    rider.press("Go via, avoid, draw…")
    rider.page.get_by_label("Choose a place").select_option("Laboratory")
    rider.press("Go via here")
    rider.sees(re.compile(r"By way of Laboratory: \+[\d.]+ m\."))
    rider.until_button("Start")
    rider.press("Start")
    way = ways(chair, lambda way: way["wishes"] and way["extra_length"] > 0.0)
    at = {place["name"]: (place["x"], place["y"]) for place in chair.scene["places"]}
    assert nearest(way["points"], at["Laboratory"]) < 0.5  # the trip visits it


def test_a_tap_outside_the_building_cancels_nothing(rider, chair):
    rider.take()
    rider.follow("Ward 4")
    rider.press("OK")  # of the mode's explanation: it would go at a time of its own,
    rider.rest(1.0)  # and a tap right after a card has gone is not the map's
    rider.press("Whole floor")
    floor = chair.scene["floor"]
    top = floor["y"] + floor["height"] * floor["resolution"]
    rider.page.mouse.click(*pixel(rider, floor["x"] + 20.0, top + 3.0))
    rider.press("Go here")
    rider.sees("This place is outside the map.")
    rider.holds(lambda state: state["goal"] and state["goal"]["name"] == "Ward 4")


def test_arrival_is_told_once(rider, chair):
    x, y, _ = chair.state["pose"]
    rider.press("Whole floor")
    rider.page.mouse.click(*pixel(rider, x, y + 2.5))
    rider.press("Go here")
    rider.until_button("Start")
    regions = "[...document.querySelectorAll('.cards > [role=status]')]"
    rider.page.evaluate(f"window.regions = {regions}")
    rider.press("Start")
    rider.until(lambda state: state["goal"])
    rider.makes(lambda state: state["arrived"], rider.go_on)
    told = rider.page.get_by_role("status").filter(has_text="You have arrived")
    expect(told).to_have_count(1)
    rider.rest(1.0)
    expect(told).to_have_count(1)
    # Only a region that was there before is announced.
    words = rider.page.evaluate("regions.filter((each) => each.isConnected && each.textContent)")
    assert len(words) == 1


def test_the_therapist_may_allow_to_set_off_at_once(rider, chair):
    rider.page.route("**/ws", lambda route: route.continue_())
    chair.say("set_goal")  # nobody drives, and nothing is chosen
    therapist = rider.context.new_page()
    therapist.goto(rider.address + f"/therapist#token={chair.token}")
    box = therapist.get_by_label("Set off without confirmation")
    box.check()
    expect(therapist.get_by_text("Saved.")).to_be_visible()
    try:
        rider.page.bring_to_front()
        rider.show("Go to")
        field = rider.page.get_by_role("searchbox", name="Search for a place")
        field.fill("ward 4")
        field.press("Enter")
        rider.until(lambda state: state["goal"] and state["goal"]["name"] == "Ward 4")
    finally:
        box.uncheck()
        expect(box).not_to_be_checked()
        therapist.close()


def shut_all(rider):
    """Shut each door; one in which a person stands, once they have gone."""
    doors = {door["id"] for door in rider.chair.scene["doors"]}
    for _ in range(20):
        for door in doors - {*rider.chair.state["closed_doors"]}:
            rider.chair.say("change_simulation", action="door", door=door, on=True)
        rider.rest(0.5)
        if doors == {*rider.chair.state["closed_doors"]}:
            return
    raise AssertionError(f"open still: {doors - {*rider.chair.state['closed_doors']}}")


def test_a_shut_door_is_named_before_the_trip(rider):
    shut_all(rider)
    shut = rider.page.get_by_text(
        re.compile("No route there is wide enough. The door to .* is shut.")
    )
    for _ in range(5):  # until the chair has seen the door: a person may stand before it
        rider.show("Go to")
        rider.press("Pharmacy")
        with suppress(AssertionError):
            expect(shut.filter(visible=True).first).to_be_visible(timeout=10_000)
            break
        rider.press("Cancel trip")
    expect(shut.filter(visible=True).first).to_be_visible()
    expect(rider.button("Start")).to_have_attribute("aria-disabled", "true")


def test_a_door_that_shuts_on_the_way_is_named_and_pointed_at(rider, chair):
    rider.take()
    rider.choose("Pharmacy")
    rider.makes(moves, rider.go_on)
    shut_all_from(rider)
    expect(rider.page.get_by_test_id("why")).to_contain_text(
        re.compile("The door to .* is shut"), timeout=60_000
    )


def shut_all_from(rider):
    """By the page that drives; first those of the destination, which is not far."""
    rider.show("Simulation")
    doors = rider.page.get_by_role("button", name=re.compile(": open$")).all_inner_texts()
    for name in sorted(doors, key=lambda door: "Pharmacy" not in door):
        # Each once, by its name: on a slow machine a shut one may still say "open".
        rider.page.get_by_role("button", name=name, exact=True).click()


def test_a_phone_keeps_its_map_under_a_sheet(riders):
    rider = riders(**PHONE)
    rider.sees("No driver.")
    rider.show("Go to")
    sheet = rider.page.locator("#panel").bounding_box()
    canvas = rider.page.locator("canvas").bounding_box()
    assert sheet["height"] <= 0.65 * canvas["height"]
    assert sheet["y"] + sheet["height"] <= canvas["y"] + canvas["height"] + 1


def test_the_way_of_following_is_kept(rider):
    heading, north = rider.button("Turn map with the chair"), rider.button(re.compile("north up"))
    expect(heading).to_have_attribute("aria-pressed", "true")  # ahead is up, at first
    north.click()
    rider.page.reload()
    rider.sees("No driver.")
    expect(north).to_have_attribute("aria-pressed", "true")


def test_the_page_speaks_german(rider):
    rider.show("Settings")
    rider.press("Deutsch")
    rider.sees("Niemand fährt.")
    assert rider.page.evaluate("document.documentElement.lang") == "de"
    rider.page.reload()
    rider.sees("Niemand fährt.")


def test_who_steers_is_one_sentence_and_nothing_while_the_chair_stands(rider):
    rider.take()
    meter = rider.page.get_by_role("meter", name="Your share of the steering")
    rider.until(stands)
    rider.sees("Standing: no trip")
    expect(meter).to_have_count(0)
    rider.hold("ArrowUp", moves)
    rider.sees("You steer")
    expect(meter).to_have_attribute("aria-valuenow", "100")
    rider.let_go("ArrowUp")


def line(rider):
    """The top line."""
    return rider.page.get_by_role("region", name="Who is in control").locator(".line")


def test_a_standing_chair_says_why_in_its_top_line(rider):
    expect(line(rider)).to_have_text("Standing: no driver")
    rider.look_at("Ward 4")
    expect(line(rider)).to_have_text("Ready: press “Start”")
    rider.press("Start")
    rider.makes(moves, rider.go_on)
    expect(line(rider)).to_contain_text("The chair steers")
    rider.press("STOP")
    rider.until(stands)
    expect(line(rider)).to_have_text("You stopped the chair.")
    rider.press("Cancel trip")
    rider.go_on()
    expect(line(rider)).to_have_text("Standing: no trip")


def test_a_hand_on_the_stick_is_told_before_the_chair_has_turned(rider):
    rider.look_at("Ward 4")
    rider.press("Start")
    rider.makes(moves, rider.go_on)
    expect(line(rider)).to_contain_text("The chair steers")
    rider.hold("ArrowUp", moves)
    expect(line(rider)).to_contain_text(re.compile("You (and the chair )?steer"))
    rider.let_go("ArrowUp")
    expect(line(rider)).to_contain_text("The chair steers")


def test_why_is_answered_now_and_a_moment_later(rider):
    rider.look_at("Ward 4")
    rider.press("Start")
    rider.makes(moves, rider.go_on)
    rider.press("STOP")
    rider.until(stands)
    rider.press("Why?")
    answer = rider.page.get_by_role("group", name="What holds or slows the chair")
    expect(answer).to_contain_text("You stopped the chair.")
    expect(answer).to_contain_text("Speed: “Normal”, at most 0.7 m/s.")
    rider.makes(moves, rider.go_on)
    expect(answer).to_contain_text(re.compile(r"\d+ s ago: You stopped the chair\."))
    rider.press("Why?")
    expect(answer).to_have_count(0)


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_no_card_lies_over_the_chair_as_it_sets_off(riders, size):
    rider = riders(viewport={"width": size[0], "height": size[1]})
    rider.sees("No driver.")
    rider.choose("Ward 4")
    card = rider.page.get_by_role("group", name="What this mode does")
    expect(card).to_be_visible()
    rider.rest(0.5)
    canvas = rider.page.locator("canvas").bounding_box()
    box = card.bounding_box()
    # The chair stands at 70 % of the height that is left, in the middle: 36 px about it are free.
    left = box["y"] - canvas["y"]
    assert rider.page.evaluate(CHAIR_COLOUR, [canvas["width"] / 2, 0.7 * left])
    assert 0.7 * left + 36 <= left


CHAIR_COLOUR = """([x, y]) => {
  const canvas = document.querySelector("canvas");
  const ratio = canvas.width / canvas.clientWidth;
  const box = [x - 12, y - 24, 24, 48].map((each) => each * ratio);
  const { data } = canvas.getContext("2d").getImageData(...box);
  const wanted = [11, 63, 99];
  for (let k = 0; k < data.length; k += 4)
    if (wanted.every((each, n) => Math.abs(data[k + n] - each) < 6)) return true;
  return false;
}"""
"""True if the colour of the chair is near a point of the map."""


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_an_open_list_stays_where_it_is_when_the_trip_ends(riders, size):
    rider = riders(viewport={"width": size[0], "height": size[1]})
    rider.sees("No driver.")
    rider.choose("Ward 4")
    rider.show("Go to")
    rider.press("Choose another destination")
    place = rider.button("Ward 2")
    before = place.bounding_box()
    rider.press("Cancel trip")
    rider.until(lambda state: state["goal"] is None)
    rider.rest(0.5)
    expect(rider.page.get_by_role("region", name="Your trip")).to_have_count(0)
    after = place.bounding_box()
    assert all(abs(after[key] - before[key]) < 1.0 for key in before)  # px, as layout rounds
