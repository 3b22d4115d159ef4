"""The therapist's riders in the page: created, chosen, edited, exported and deleted; progress."""

import json
import re
import zipfile
from pathlib import Path

import pytest
from playwright.sync_api import expect

from cohelm.live.sessions.database import Database

from .served import held
from .test_access import AXE, SIZES, STOP, TARGETS, faults, page_of, unreached

HTML = "<img src=x onerror=alert(1)><b>left hand</b>"
NAMES = "Ana Példa", "Bo 17"


def session(folder, number, rider, **measures):
    """A stored session with one ride, of day ``number``."""
    id_ = f"202601{number:02}-101010"
    started = f"2026-01-{number:02}T10:10:10+00:00"
    facts = {"id": id_, "started": started, "scene": "hospital", "robot": "chair", "rider": rider}
    limits = {"max_speed": 0.5, "max_acceleration": 0.4, "min_distance": 0.8}
    ride = {
        "id": f"{id_}-r1", "session": id_, "started": started, "seed": 0, "destination": "Ward 4",
        "outcome": "arrived", "duration": 60.0, "length": 50.0, "modes": {"manual": 60.0},
        "limits": [{"time": 0.0, "limits": limits}], "measures": measures,
    }  # fmt: skip
    Database(folder).write(
        "INSERT INTO ride VALUES (?, ?, ?, 'unmeasured', ?, ?, NULL, NULL)",
        ride["id"], id_, rider, json.dumps(facts), json.dumps(ride),
    )  # fmt: skip
    return id_


def riders_in(folder):
    """Ids of the stored riders."""
    return [id_ for (id_,) in Database(folder).rows("SELECT id FROM rider")]


class Therapist:
    """A therapist who is signed in."""

    def __init__(self, riders, chair, size="desktop"):
        path = f"/therapist#token={chair.token}"
        self.rider = page_of(riders, size, path=path)
        self.page = self.rider.page
        self.rider.sees("names, notes and goals".capitalize())

    def add(self, name, notes="", goals=()):
        self.rider.press("New rider…")
        self.page.get_by_label("Name or number").fill(name)
        self.page.get_by_label("Notes").fill(notes)
        for n, target in enumerate(goals, 1):
            self.rider.press("Add a goal")
            self.page.get_by_label(f"Kind of goal {n}").select_option("unaided")
            self.page.get_by_label(f"Number of trips of goal {n}").fill(str(target))
        self.rider.press("Save rider")
        self.rider.sees(f"{name} is stored.")

    def row(self, name):
        return self.page.locator("details", has=self.page.locator("summary", has_text=name)).first

    def choose(self, name):
        self.row(name).get_by_role("button", name="Choose as rider").click()
        self.rider.sees(f"Riding now: {name}")

    def delete(self, name):
        self.row(name).get_by_role("button", name="Delete…").click()
        self.rider.press("Delete the rider and their sessions")
        self.rider.sees(re.compile("^Deleted, with"))


@pytest.fixture
def data(chair):
    """The chair's data folder, without riders at the beginning and at the end."""
    folder = chair.log.parent / "data"
    yield folder
    for table in ("rider", "ride"):
        Database(folder).write(f"DELETE FROM {table}")


@pytest.fixture
def therapist(riders, chair, data):
    return Therapist(riders, chair)


def test_stop_is_above_every_dialog(therapist, riders, data):
    """There it takes the first press, and Tab comes to it; Esc is STOP as ever."""
    session(data, 1, "")
    page, rider = therapist.page, therapist.rider
    page.reload()
    therapist.add(NAMES[0])
    driver = riders()
    driver.take()
    openers = (
        therapist.row(NAMES[0]).get_by_role("button", name="Delete…"),
        rider.button("Delete all…"),
    )
    for opener in openers:
        opener.click()
        dialog = page.get_by_role("dialog")
        expect(dialog).to_be_visible()
        stop = page.evaluate(STOP)
        assert (stop["count"], stop["inside"], stop["top"]) == (1, True, True)
        assert unreached(rider) == []
        box = page.get_by_text("STOP", exact=True).bounding_box()
        driver.go_on()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        driver.until(lambda state: held(state) and state["link"] == "confirm")
        expect(dialog).to_be_visible()
        driver.go_on()
        page.keyboard.press("Escape")
        driver.until(lambda state: held(state) and state["link"] == "confirm")
        expect(dialog).to_have_count(0)
        expect(opener).to_be_focused()
    therapist.delete(NAMES[0])


def test_wrong_input_is_named_and_nothing_is_stored(therapist, data):
    page, rider = therapist.page, therapist.rider
    rider.press("New rider…")
    name = page.get_by_label("Name or number")
    expect(name).to_be_focused()
    rider.press("Save rider")
    rider.sees("A name or a number is missing.")
    expect(name).to_be_focused()
    name.fill("x" * 10_000)
    rider.sees("At most 80 characters; now 10,000.")
    name.fill(NAMES[0])
    page.get_by_label("Notes").fill("x" * 2001)
    rider.press("Save rider")
    rider.sees("At most 2,000 characters; now 2,001.")
    expect(page.get_by_label("Notes")).to_be_focused()
    form = page.get_by_role("form", name="New rider")
    form.get_by_label("Maximum speed, m/s").fill("9")
    rider.sees("Between 0.1 and 3 m/s.")
    assert not riders_in(data)
    rider.press("Cancel")
    expect(rider.button("New rider…")).to_be_focused()


def test_a_rider_is_created_chosen_edited_and_deleted(therapist, chair, data):
    page, rider = therapist.page, therapist.rider
    limits = page.request.get(f"{rider.address}/api/limits").json()
    therapist.add(NAMES[0], HTML, goals=[10])
    rider.sees(HTML)  # as it was written, and not as a page
    assert page.locator(".notes img, .notes b").count() == 0
    rider.sees("0 of 10 trips without help in steering")
    rider.press("New rider…")
    page.get_by_label("Name or number").fill(f" {NAMES[0].lower()} ")
    rider.press("Save rider")
    rider.sees("Another rider has this name or number.")
    rider.press("Cancel")
    before = page.get_by_label("Maximum speed, m/s").input_value()
    row = therapist.row(NAMES[0])
    row.get_by_role("button", name="Edit…").click()
    form = page.get_by_role("form", name=f"Edit {NAMES[0]}")
    form.get_by_label("Maximum speed, m/s").fill("0.4")
    form.get_by_label("Mode").select_option(label="Stop only")
    rider.press("Save rider")
    rider.sees(f"{NAMES[0]} is stored.")
    expect(page.get_by_label("Maximum speed, m/s")).to_have_value(before)  # not in force yet
    therapist.choose(NAMES[0])
    rider.sees("Applied: Maximum speed 0.4 m/s")
    expect(page.get_by_label("Maximum speed, m/s")).to_have_value("0.4")
    rider.until(lambda state: state["mode"] == "stop_only")
    page.get_by_label("Maximum speed, m/s").fill("0.5")
    page.get_by_role("button", name="Apply", exact=True).first.click()  # that of the limits
    rider.sees("The limits in force are not those of the preset.")
    expect(page.get_by_text("rides now, without a destination. Applied")).to_have_count(
        0
    )  # it was true before
    database = Database(data)
    (stored,) = riders_in(data)
    assert json.loads(database.setting("settings"))["person"] == stored
    therapist.delete(NAMES[0])
    rider.sees("Nobody is chosen")
    assert NAMES[0].encode() not in database.file.read_bytes()
    # the same chair serves other tests
    headers = {"Origin": rider.address}
    assert page.request.put(f"{rider.address}/api/limits", data=limits, headers=headers).ok
    chair.say("set_mode", mode="shared")
    rider.until(lambda state: state["mode"] == "shared")


def test_progress_is_shown_with_its_meaning_and_no_direction_from_two(therapist, data, tmp_path):
    page, rider = therapist.page, therapist.rider
    therapist.add(NAMES[1], goals=[2])
    (stored,) = riders_in(data)
    for day in (1, 2):
        session(data, day, stored, rider_reversals=30.0 - day, min_distance=0.5)
    page.reload()
    row = therapist.row(NAMES[1])
    row.locator("summary").first.click()
    rider.sees("2 of the 6 sessions in this mode that are needed to tell a direction.")
    rider.sees("2 of 2 trips without help in steering")
    assert row.locator("polyline").count() == 0
    for day in range(3, 8):
        session(data, day, stored, rider_reversals=30.0 - day, min_distance=0.5)
    page.reload()
    row.locator("summary").first.click()
    rider.sees("Falling over 7 sessions in this mode.")
    plot = row.get_by_role("img", name=re.compile("^Stick reversals"))
    expect(plot).to_have_attribute(
        "aria-label",
        "Stick reversals, per minute: from 29.0 in the first to 23.0 in the latest of 7 sessions,"
        " between 23.0 and 29.0. Falling over 7 sessions in this mode.",
    )
    assert plot.locator("circle").count() == 7
    row.get_by_text("All values as a table").click()
    assert row.get_by_role("row").count() == 8
    with page.expect_download() as download:
        row.get_by_role("link", name="Export (ZIP)").click()
    archive = tmp_path / "rider.zip"
    download.value.save_as(archive)
    assert NAMES[1] not in download.value.suggested_filename
    with zipfile.ZipFile(archive) as inside:
        assert len([each for each in inside.namelist() if each.endswith(".html")]) == 7
    therapist.delete(NAMES[1])
    rider.sees("Deleted, with 7 sessions.")
    assert not Database(data).rows("SELECT id FROM ride WHERE state != 'deleted'")


def test_a_damaged_rider_is_told_and_a_full_disk_keeps_the_form(therapist, data):
    page, rider = therapist.page, therapist.rider
    therapist.add(NAMES[0])
    (stored,) = riders_in(data)
    database = Database(data)
    database.write("UPDATE rider SET record = '{' WHERE id = ?", stored)
    page.reload()
    rider.sees(f"The record of this rider ({stored}) cannot be read.")
    rider.press("New rider…")
    page.get_by_label("Name or number").fill(NAMES[1])
    journal = Path(f"{database.file}-journal")
    journal.mkdir()  # where SQLite writes first: nothing can be written
    rider.press("Save rider")
    rider.sees(re.compile("^Not saved: .*annot be (read now|written)"))
    expect(page.get_by_label("Name or number")).to_have_value(NAMES[1])
    journal.rmdir()
    rider.press("Save rider")
    rider.sees(f"{NAMES[1]} is stored.")


@pytest.mark.parametrize("size", [each for each in SIZES if each != "tablet"])
def test_riders_are_for_everybody(riders, chair, data, size):
    """Rules, targets, Tab and STOP, with a form and with plots."""
    if not AXE.is_file():
        pytest.skip("needs axe-core: npm ci in page/")
    therapist = Therapist(riders, chair, size)
    rider, page = therapist.rider, therapist.page
    therapist.add(NAMES[0], HTML, goals=[10])
    (stored,) = riders_in(data)
    id_ = session(data, 1, stored, rider_reversals=30.0, min_distance=0.5)
    page.reload()
    therapist.row(NAMES[0]).locator("summary").first.click()
    therapist.row(NAMES[0]).get_by_text("All values as a table").click()
    rider.press("New rider…")
    rider.press("Add a goal")
    rider.press("Save rider")
    rider.sees("A name or a number is missing.")
    palettes = {"phone": ("light",), "desktop": ("dark", "contrast")}[size]
    assert faults(rider, palettes) == {}
    assert page.evaluate(TARGETS) == []
    if size == "phone":
        assert unreached(rider) == []
    assert page.evaluate(STOP)["least"] >= 72.0
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    rider.press("Cancel")
    therapist.row(NAMES[0]).get_by_role("button", name="Delete…").click()
    assert faults(rider, ("dark",)) == {}
    rider.press("Delete the rider and their sessions")
    rider.sees("Deleted, with one session.")
    assert not (data / id_).exists()
