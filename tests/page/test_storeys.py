"""A trip to another storey by lift: to the lift, the rider's word, the other map, the place."""

import re
from contextlib import closing

import pytest
from playwright.sync_api import expect

from cohelm.buildings import read_building, write_storey
from tests.buildings.authored import lift_tower

from .rider import Rider
from .served import Chair

pytestmark = pytest.mark.slow
START = re.compile("^Start")


@pytest.fixture
def tower(tmp_path):
    rooms = (("101", "Foyer"), ("201", "Ward 3"), ("301", "Pharmacy"))
    model = lift_tower(marked=("room",), rooms=rooms).write(tmp_path / "tower.ifc")
    folder = tmp_path / "floors"
    folder.mkdir()
    for storey in read_building(model):
        write_storey(storey, folder)
    return folder


def test_a_trip_leads_to_another_storey_by_lift(browser, tower, tmp_path):
    options = ("empty", "--map", str(tower), "--start", "Foyer", "--people", "0")
    with Chair(tmp_path, *options) as chair, closing(Rider(browser, chair)) as rider:
        rider.sees("You are in")
        rider.press("Pharmacy")
        rider.button(START).first.click(timeout=60_000)
        rider.sees("then by lift to Level 3, Pharmacy")
        there = rider.button("I am on Level 3")
        expect(there).to_be_visible(timeout=240_000)
        rider.sees("You are in Lift A, Level 1.")
        there.click()
        rider.button(START).first.click(timeout=240_000)
        expect(rider.page.get_by_text("You are in Pharmacy, Level 3.")).to_be_visible(
            timeout=240_000
        )
        expect(
            rider.page.get_by_text(re.compile("You have arrived: Pharmacy")).first
        ).to_be_visible(timeout=60_000)
        assert rider.faults == []
