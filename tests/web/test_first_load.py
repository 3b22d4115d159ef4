"""The built page in a real Chromium: what it loads, from where, and that its rules bear it."""

from pathlib import Path

import pytest

from cohelm.web.page_files import FOLDER, read_page

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip

pytestmark = [
    pytest.mark.skipif(not CHROMIUM.exists(), reason="needs Chromium: make chromium"),
    pytest.mark.skipif(not (FOLDER / "index.html").is_file(), reason="not built: make page"),
]


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=list(FLAGS))
        yield browser
        browser.close()


@pytest.mark.parametrize("path", ["/", "/therapist"])
def test_first_load(chromium, served, drive, path):
    """All from this server, at most 150 kB on the wire, and nothing that its policy forbids."""
    tokens = {"therapist": served.tokens["therapist"]}
    with served(drive, tokens=tokens, page=read_page()) as server:
        view = chromium.new_page()
        addresses, sizes, said = [], [], []
        view.on("console", lambda message: said.append((message.type, message.text)))
        view.on("pageerror", lambda error: said.append(("error", str(error))))
        view.on("request", lambda request: addresses.append(request.url))
        view.on("requestfinished", lambda request: sizes.append(request.sizes()))
        view.goto(server.origin + path)
        view.wait_for_selector("button, input")
        view.wait_for_timeout(500)
        view.close()
    assert {address.split("/")[2] for address in addresses} == {server.name}
    assert sum(size["responseBodySize"] for size in sizes) <= 150_000
    # The 3-D view has a file of its own, which is loaded when it is opened.
    assert any((FOLDER / "assets").glob("View-*.js"))
    assert not any("/View-" in address for address in addresses)
    faults = [text for kind, text in said if kind in {"error", "warning"}]
    allowed = ("401", "403") if path == "/therapist" else ()
    assert [text for text in faults if not any(code in text for code in allowed)] == []


def test_a_link_with_a_token_signs_in_and_is_forgotten(chromium, served, drive):
    with served(drive, page=read_page()) as server:
        context = chromium.new_context()
        view = context.new_page()
        view.goto(f"{server.origin}/#token={server.tokens['driver']}")
        view.wait_for_function("!location.hash.includes('token')")
        for _ in range(100):
            if drive.joined_as:
                break
            view.wait_for_timeout(50)
        assert set(drive.joined_as.values()) == {"driver"}
        cookies = context.cookies()
        assert [cookie["httpOnly"] for cookie in cookies] == [True]
        context.close()
