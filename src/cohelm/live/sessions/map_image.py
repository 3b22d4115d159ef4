"""Map as a grey picture along the map's axes."""

from __future__ import annotations

import hashlib
from io import BytesIO

import numpy as np
from PIL import Image

from cohelm.arrays import Bytes
from cohelm.live.messages import FloorInfo
from cohelm.maps import OccupancyGrid

_OCCUPIED, _UNKNOWN, _FREE = 0, 128, 255


def map_image(grid: OccupancyGrid) -> tuple[FloorInfo, bytes]:
    """Return a grid as a grey PNG along the map's axes, first row at the top, and its position."""
    corner = grid.bounds[:2]
    grey = _grey(grid)
    if grid.X_MG[2] != 0.0:
        grey = _aligned(grid, grey)
    rows, cols = grey.shape
    out = BytesIO()
    Image.fromarray(grey[::-1]).save(out, format="PNG", optimize=True)
    png = out.getvalue()
    digest = hashlib.sha256(png).hexdigest()[:16]
    floor = FloorInfo(
        image=f"/api/floor/{digest}.png",
        width=cols,
        height=rows,
        resolution=grid.resolution,
        x=corner[0],
        y=corner[1],
    )
    return floor, png


def _grey(grid: OccupancyGrid) -> Bytes:
    grey = np.full(grid.shape, _FREE, dtype=np.uint8)
    grey[grid.data < 0] = _UNKNOWN
    grey[grid.occupied()] = _OCCUPIED
    return grey


def _aligned(grid: OccupancyGrid, grey: Bytes) -> Bytes:
    """Resample the image of a rotated grid along the map's axes."""
    x0, y0, x1, y1 = grid.bounds
    size = grid.resolution
    xs = np.arange(x0 + size / 2.0, x1, size)
    ys = np.arange(y0 + size / 2.0, y1, size)
    points = np.stack(np.meshgrid(xs, ys), axis=-1)
    cells, inside = grid.cells(points), grid.contains(points)
    out = np.full(inside.shape, _UNKNOWN, dtype=np.uint8)
    out[inside] = grey[cells[inside][:, 0], cells[inside][:, 1]]
    return out
