"""Frames of the 3-D view in Chromium without a graphics card, and what it loads.

    python benchmarks/view3d.py                         # all figures
    python benchmarks/view3d.py --pictures docs/images  # the pictures of the documents instead

``cohelm drive`` runs beside it on the hospital floor with 12 people. A frame counts if something
was drawn in it: the draw calls of WebGL are watched.
"""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page, expect, sync_playwright

import page as rider_page

FLAGS = [*rider_page.FLAGS, "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = (1280, 800)
PEOPLE = 12
SECONDS = 8.0
CAMERAS = ("From behind", "From above", "Rider’s eyes")
VIEWS = {
    "planar": {
        "view3d-behind": ("From behind", "light"),
        "view3d-above": ("From above", "light"),
        "view3d-eyes": ("Rider’s eyes", "light"),
    },
    "twin": {"view3d-twin": ("From behind", "light")},
}
"""Platform → name of a picture → camera and colour scheme."""
LARGEST = 150_000
"""Maximum size of a picture, bytes."""
DRAWN = """
seconds => new Promise((done) => {
  const proto = WebGL2RenderingContext.prototype;
  const draw = proto.drawElements;
  const at = [];
  let drew = false;
  proto.drawElements = function (...all) { drew = true; return draw.apply(this, all); };
  const begin = performance.now();
  requestAnimationFrame(function frame(now) {
    if (drew) at.push(now);
    drew = false;
    if (now - begin < 1000 * seconds) return requestAnimationFrame(frame);
    proto.drawElements = draw;
    done(at);
  });
})
"""
RATIO = """() => {
  const { width, clientWidth } = document.querySelector("canvas");
  return width / clientWidth;
}"""


def main() -> int:
    """Print all figures, or make the pictures."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--pictures", type=Path)
    chosen = options.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=rider_page.CHROMIUM, args=FLAGS, ignore_default_args=["--disable-gpu"]
        )
        if chosen.pictures is None:
            with rider_page.served(PEOPLE) as (address, _):
                frames(browser, address)
            return 0
        for platform, views in VIEWS.items():
            with rider_page.served(PEOPLE, "--platform", platform) as (address, _):
                pictures(browser, address, views, chosen.pictures)
    return 0


def show(page: Page) -> None:
    """Open the 3-D view and wait for its first frame."""
    page.get_by_role("button", name="3-D view").click()
    expect(page.get_by_role("button", name="From behind")).to_be_visible(timeout=60_000)


def frames(browser: Browser, address: str) -> None:
    """Measure the frame rate of each camera while the chair drives among people."""
    with rider_page.opened(browser, address, *SIZE) as page:
        sizes: list[int] = []
        page.on(
            "requestfinished",
            lambda request: sizes.append(request.sizes()["responseBodySize"]),
        )
        show(page)
        print(f"opening the view loads {sum(sizes) / 1000:.1f} kB in {len(sizes)} requests")
        rider_page.take(page)
        rider_page.go(page, "Ward 4")
        rider_page.ride(page, 3.0)
        for camera in CAMERAS:
            page.get_by_role("button", name=camera).click()
            page.wait_for_timeout(2500)
            gaps = np.diff(np.array(page.evaluate(DRAWN, SECONDS)))
            load = os.getloadavg()[0]
            print(
                f"{camera}: {1000.0 / gaps.mean():.1f} frames/s,"
                f" gaps median {np.median(gaps):.0f} ms, p99 {np.percentile(gaps, 99):.0f} ms,"
                f" {page.evaluate(RATIO):.2f} pixels for each of the page, load {load:.1f};"
                f" {page.locator('.numbers').inner_text()}"
            )
        rider_page.release(page)


def pictures(
    browser: Browser, address: str, views: Mapping[str, tuple[str, str]], folder: Path
) -> None:
    """Make one picture for each view, drawn twice as fine and made smaller."""
    for name, (camera, scheme) in views.items():
        with rider_page.opened(
            browser, address, *SIZE, device_scale_factor=2, color_scheme=scheme
        ) as page:
            show(page)
            page.get_by_role("button", name=camera).click()
            rider_page.take(page)
            rider_page.go(page, "Ward 4")
            rider_page.ride(page, 6.0)
            keep(page, folder / f"{name}.png")
            rider_page.release(page)


def keep(page: Page, path: Path) -> None:
    """Write a picture of half the size with a reduced palette."""
    shown = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shown = shown.resize((shown.width // 2, shown.height // 2), Image.Resampling.LANCZOS)
    shown.quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path} is too large")


if __name__ == "__main__":
    sys.exit(main())
