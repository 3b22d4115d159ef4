"""Map of a ride as a PNG: floor, planned route and driven track.

It uses Pillow only, so that a live ride needs no plotting library.
"""

from __future__ import annotations

import io

import numpy as np
from PIL import Image, ImageDraw

from cohelm.arrays import Floats
from cohelm.evaluation.episode.ride import Ride
from cohelm.geometry import inverse, transform

MAX_SIDE = 1200
"""Maximum side of the picture, pixels."""
MARGIN = 3.0
"""Margin around the track, m."""
_FINE = 2
"""Supersampling factor."""
_SAMPLES = 4000
"""Maximum number of points of a track."""
_SHADES = 8
"""Number of colours between the chair's and the rider's."""

_FLOOR, _WALL, _UNKNOWN = (255, 255, 255), (52, 60, 71), (226, 229, 233)
_ROUTE, _WITHOUT, _PEOPLE = (90, 140, 220), (170, 176, 184), (224, 186, 170)
_CHAIR_STEERS, _RIDER_STEERS = np.array([36, 84, 160]), np.array([222, 120, 20])
_START, _GOAL, _TOUCH = (40, 130, 70), (150, 40, 120), (200, 30, 30)


def ride_map(ride: Ride) -> bytes:
    """Return a PNG with the track, blue where the chair steered and orange where the rider did.

    It also shows the first route, in grey the route without wishes, people's tracks as dots, start
    (green), goal (purple) and contacts (red).
    """
    X_GM = inverse(ride.grid.X_MG)
    track = transform(X_GM, _thin(ride.pose[:, :2]))
    lines = [track]
    if ride.path is not None:
        lines += [transform(X_GM, ride.path.points), transform(X_GM, ride.path.without_wishes)]
    low, high = _window(ride, lines)
    scale = _FINE * min(40.0, MAX_SIDE / float((high - low).max()))
    image = _floor(ride, low, high, scale)
    sheet = _Sheet(ImageDraw.Draw(image), low, scale, image.height)
    for person in range(ride.people.shape[1]):
        sheet.dots(transform(X_GM, _thin(ride.people[:, person, :2])), _PEOPLE, 0.04)
    if ride.path is not None:
        sheet.line(lines[2], _WITHOUT, 0.06)
        sheet.line(lines[1], _ROUTE, 0.08)
    _draw_track(sheet, track, _thin(ride.eta[:, None])[:, 0])
    touched = ride.hit_moving.any(axis=1) | ride.hit_wall
    for point in transform(X_GM, ride.pose[touched, :2])[:50]:
        sheet.disc(point, _TOUCH, 0.3)
    sheet.disc(track[0], _START, 0.25)
    if np.isfinite(ride.goal).all():
        sheet.disc(transform(X_GM, ride.goal), _GOAL, 0.3)
    small = image.resize((image.width // _FINE, image.height // _FINE), Image.Resampling.LANCZOS)
    out = io.BytesIO()
    small.quantize(256, Image.Quantize.FASTOCTREE).save(out, "PNG", optimize=True)
    return out.getvalue()


def _window(ride: Ride, lines: list[Floats]) -> tuple[Floats, Floats]:
    """Corners (2,) of the visible area, in the grid's frame, m."""
    points = np.concatenate(lines)
    size = np.array(ride.grid.size)
    low = np.clip(points.min(axis=0) - MARGIN, 0.0, size)
    return low, np.maximum(np.clip(points.max(axis=0) + MARGIN, 0.0, size), low + 1.0)


def _floor(ride: Ride, low: Floats, high: Floats, scale: float) -> Image.Image:
    grid = ride.grid
    r0, c0 = (max(int(v / grid.resolution), 0) for v in low[::-1])
    r1, c1 = (int(np.ceil(v / grid.resolution)) for v in high[::-1])
    data = grid.data[r0:r1, c0:c1]
    pixels = np.full((*data.shape, 3), _FLOOR, dtype=np.uint8)
    pixels[data < 0] = _UNKNOWN
    pixels[grid.occupied()[r0:r1, c0:c1]] = _WALL
    width, height = (max(round(float(side) * scale), 1) for side in high - low)
    return Image.fromarray(pixels[::-1]).resize((width, height), Image.Resampling.BOX)


def _draw_track(sheet: _Sheet, track: Floats, eta: Floats) -> None:
    """Draw each piece of one colour at once, so that its joints are round."""
    level = np.rint(np.clip(eta, 0.0, 1.0) * _SHADES).astype(np.int64)
    ends = np.append(np.flatnonzero(np.diff(level)) + 1, len(track) - 1)
    begin = 0
    for end in ends.tolist():
        share = level[begin] / _SHADES
        red, green, blue = ((1.0 - share) * _CHAIR_STEERS + share * _RIDER_STEERS).tolist()
        sheet.line(track[begin : end + 1], (int(red), int(green), int(blue)), 0.14)
        begin = end


def _thin(points: Floats) -> Floats:
    """Thin out points (k, d), keeping the last."""
    every = max(int(np.ceil(len(points) / _SAMPLES)), 1)
    kept = np.unique(np.append(np.arange(0, len(points), every), len(points) - 1))
    return np.asarray(points[kept])


class _Sheet:
    """Drawing surface that takes points of the grid's frame, m."""

    def __init__(self, draw: ImageDraw.ImageDraw, low: Floats, scale: float, height: int) -> None:
        self._draw, self._low, self._scale, self._height = draw, low, scale, height

    def line(self, points: Floats, colour: tuple[int, int, int], width: float) -> None:
        """Draw a polyline (k, 2); ``width`` in m."""
        pixels = self._pixels(points)
        self._draw.line(pixels, fill=colour, width=self._size(width), joint="curve")

    def dots(self, points: Floats, colour: tuple[int, int, int], radius: float) -> None:
        """Draw points (k, 2) at least a metre apart; NaN are skipped."""
        last: Floats | None = None
        for point in points[np.isfinite(points).all(axis=1)]:
            if last is None or float(np.hypot(*(point - last))) >= 1.0:
                self.disc(point, colour, radius)
                last = point

    def disc(self, point: Floats, colour: tuple[int, int, int], radius: float) -> None:
        """Draw a disc at a point (2,)."""
        (x, y), r = self._pixels(point[None])[0], self._size(radius)
        self._draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)

    def _pixels(self, points: Floats) -> list[tuple[float, float]]:
        away = (points - self._low) * self._scale
        return [(float(x), self._height - float(y)) for x, y in away]

    def _size(self, metres: float) -> int:
        return max(round(metres * self._scale), 2)
