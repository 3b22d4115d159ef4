"""One chair and one browser for all of these tests; a page of its own for each."""

from pathlib import Path

import pytest

from cohelm.web.page_files import FOLDER

from .rider import Rider
from .served import Chair

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
HERE = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)  # before the workers' tests are told apart
def pytest_collection_modifyitems(items):
    """One worker runs them all, so that there is one chair."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("page"))


@pytest.fixture(scope="package")
def browser():
    if not CHROMIUM.exists():
        pytest.skip("needs Chromium: make chromium")
    if not (FOLDER / "index.html").is_file():
        pytest.skip("the page is not built: make page")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def running(browser, tmp_path_factory):
    """The chair among a few people on a hospital's floor."""
    with Chair(tmp_path_factory.mktemp("chair"), "hospital", "--people", "4") as chair:
        yield chair


@pytest.fixture
def chair(running):
    """The same chair, as at its beginning."""
    if not running.untouched:
        running.restart()
    running.told.clear()
    return running


@pytest.fixture
def riders(browser, chair):
    """Opens pages."""
    opened = []

    def open_page(**options):
        rider = Rider(browser, chair, **{"viewport": {"width": 1280, "height": 800}, **options})
        opened.append(rider)
        return rider

    yield open_page
    for rider in opened:
        rider.close()
    assert [fault for rider in opened for fault in rider.faults] == []


@pytest.fixture
def rider(riders):
    """At a page of their own, who sees the chair."""
    rider = riders()
    rider.sees("No driver.")
    return rider


@pytest.fixture
def timely(chair):
    """Bounds how long a story's chair takes to stand, s, by the clock of the chair itself."""

    def check(story, bound=0.4):
        since = chair.state["clock"]
        took, late = story(), chair.lateness(since)
        if took > bound and late > 0.03:  # not the page but the machine: once more
            took, late = story(), chair.lateness(since)
        assert took <= bound, f"{took:.3f} s, and the machine itself up to {late:.3f} s late"

    return check
