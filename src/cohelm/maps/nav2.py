"""Occupancy grids as Nav2's map_server reads and writes them: a YAML file and an image beside it.

The semantics are those of ``nav2_map_server``. With x the pixel's lightness (0 … 255), its
occupancy is p = (255 − x)/255, or x/255 with ``negate``, and in the modes

    trinary   p ≥ occupied_thresh → 100,  p ≤ free_thresh → 0,  between → unknown
    scale     the same at the ends, between → 100·(p − free_thresh)/(occupied_thresh − free_thresh)
    raw       x itself where x ≤ 100, else unknown; neither ``negate`` nor thresholds count

A pixel that is not fully opaque is unknown, save in raw. The image's last row is the grid's first.
Quotients are compared as exact decimals would be: x = 204 is p = 0.2 and reaches a threshold 0.2.

Check that a PNG holds all its rows: the decoder fills what is missing with black.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from PIL import Image, UnidentifiedImageError
from pydantic import Field, field_validator, model_validator

from cohelm import config
from cohelm.arrays import Booleans, Bytes, SignedBytes
from cohelm.errors import MapError
from cohelm.maps.grid import FREE, MAX_COORDINATE, OCCUPIED, UNKNOWN, OccupancyGrid
from cohelm.maps.nav2_yaml import MapWarning, known_part, read_nav2_yaml
from cohelm.maps.pnm_check import surplus_bytes

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Number of channels by colour type (PNG specification, 11.2.2)."""


def missing_rows(file: Path) -> int:
    """Number of rows that the pixel data of a PNG lacks; 0 for an interlaced one.

    Raises:
        ValueError, struct.error: if it is damaged otherwise.
    """
    data = file.read_bytes()
    if not data.startswith(_SIGNATURE):
        raise ValueError("no PNG")
    at, held, header = len(_SIGNATURE), [], b""
    while at + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"IHDR":
            header = data[at + 8 : at + 8 + length]
        if kind == b"IDAT":
            held.append(data[at + 8 : at + 8 + length])
        at += 12 + length
    width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", header)
    if interlaced or colour not in _CHANNELS:
        return 0
    row = 1 + (width * bits * _CHANNELS[colour] + 7) // 8
    try:
        pixels = zlib.decompressobj().decompress(b"".join(held), row * height)
    except zlib.error as fault:
        raise ValueError(f"{fault}") from None
    return int(height - len(pixels) // row)


PIXEL_LIMIT = 100_000_000
"""Largest image that is decoded, in pixels."""

Mode = Literal["trinary", "scale", "raw"]
ImageFormat = Literal["pgm", "png"]

_FREE_PIXEL, _UNKNOWN_PIXEL, _OCCUPIED_PIXEL = 254, 205, 0
_IMAGE_SUFFIXES = (".pgm", ".png")
_DECODERS = ("PPM", "PNG", "BMP", "JPEG")
_BARE_RESOLUTION = 0.05


class MapFile(config.Model):
    """YAML file of a map, with Nav2's keys and defaults."""

    image: str = Field(min_length=1)
    """The image; relative to the YAML file, or absolute."""
    resolution: float = Field(ge=1e-4, le=100.0)
    """Side of a pixel, m."""
    origin: tuple[float, float, float]
    """[x, y, yaw] of the lower left corner in the map frame; m and rad."""
    occupied_thresh: float = Field(ge=0.0, le=1.0)
    """Occupancy from which on a pixel is occupied."""
    free_thresh: float = Field(ge=0.0, le=1.0)
    """Occupancy up to which a pixel is free."""
    mode: Mode = "trinary"
    """Conversion of lightness to occupancy; see the module."""
    negate: bool = False
    """Light pixels are occupied."""

    @field_validator("origin", mode="before")
    @classmethod
    def _three_numbers(cls, given: Any) -> Any:
        if not (isinstance(given, list | tuple) and len(given) == 3):
            raise ValueError("must be three numbers [x, y, yaw], in m and rad")
        return given

    @field_validator("origin")
    @classmethod
    def _within_reach(cls, origin: tuple[float, float, float]) -> tuple[float, float, float]:
        if max(map(abs, origin)) > MAX_COORDINATE:
            raise ValueError(f"must lie within {MAX_COORDINATE:g} m of (0, 0)")
        return origin

    @field_validator("mode", mode="before")
    @classmethod
    def _any_case(cls, given: Any) -> Any:
        return given.lower() if isinstance(given, str) else given

    @model_validator(mode="after")
    def _thresholds_in_order(self) -> MapFile:
        if self.free_thresh > self.occupied_thresh:
            raise ValueError(
                f"free_thresh ({self.free_thresh:g}) must not exceed "
                f"occupied_thresh ({self.occupied_thresh:g})"
            )
        return self


def read_map(file: Path | str, *, pixel_limit: int = PIXEL_LIMIT) -> OccupancyGrid:
    """Read the grid of a map YAML or a bare image.

    If the image named in the YAML is missing, one with the YAML's stem in the same folder is read.
    A bare image is read with 0.05 m per pixel, its corner at the origin and the usual thresholds.
    Both give a :class:`MapWarning`.

    Args:
        file: a map YAML, or an image.
        pixel_limit: an image with more pixels than that is refused before it is decoded.

    Raises:
        MapError: if a file is missing or unreadable, or has an invalid value; names the file.
    """
    file = Path(file)
    if file.suffix.lower() in {".yaml", ".yml"}:
        about = known_part(MapFile, read_nav2_yaml(file), file)
        image_file = _find_image(file, about.image)
    else:
        about, image_file = _bare(file), file
    lightness, opaque = _read_image(image_file, pixel_limit)
    if image_file is file:
        _warn_of_bare_image(file)
    _warn_of_lost_unknowns(file, about, lightness)
    return OccupancyGrid(
        data=occupancy(lightness, opaque, about)[::-1],
        resolution=about.resolution,
        X_MG=np.array(about.origin),
    )


def write_map(
    grid: OccupancyGrid, yaml_file: Path | str, image_format: ImageFormat = "pgm"
) -> None:
    """Write a grid as a map YAML and, beside it, an image with the same stem.

    A grid of free, occupied and unknown cells is written in mode trinary with 254, 0 and 205, and
    with ``free_thresh: 0.196``, so that 205 (p = 0.1961) reads as unknown again; a grid with graded
    cells in mode raw, which keeps them. ``read_map`` restores the same grid.

    Raises:
        MapError: if a file cannot be written, or its name or format is not one of a map.
    """
    yaml_file = Path(yaml_file)
    if yaml_file.suffix.lower() not in {".yaml", ".yml"}:
        raise MapError("the name of a map must end in .yaml", file=yaml_file)
    if image_format not in {"pgm", "png"}:
        raise MapError(f"cannot write {image_format!r}: use pgm or png", file=yaml_file)
    graded = bool(np.any((grid.data > FREE) & (grid.data < OCCUPIED)))
    image_file = yaml_file.with_suffix(f".{image_format}")
    about = {
        "image": image_file.name,
        "mode": "raw" if graded else "trinary",
        "resolution": float(grid.resolution),
        "origin": [float(v) for v in grid.X_MG],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    pixels = _raw_pixels(grid.data) if graded else _trinary_pixels(grid.data)
    try:
        Image.fromarray(np.ascontiguousarray(pixels[::-1])).save(image_file)
        text = yaml.safe_dump(about, sort_keys=False, default_flow_style=None, allow_unicode=True)
        yaml_file.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise MapError(f"cannot be written ({cause})", file=yaml_file) from cause


def occupancy(lightness: Bytes, opaque: Booleans, about: MapFile) -> SignedBytes:
    """Occupancy (rows, cols), −1 unknown, 0 … 100, of an image's pixels, in the image's row order.

    Args:
        lightness: (rows, cols), 0 black … 255 white.
        opaque: (rows, cols), false where the image is transparent to any degree.
        about: the mode, the thresholds and ``negate``.
    """
    cells: SignedBytes = _occupancy_of_lightness(about)[lightness]
    if about.mode != "raw":
        cells[~opaque] = UNKNOWN
    return cells


def _occupancy_of_lightness(about: MapFile) -> SignedBytes:
    """The cell value of each of the 256 shades."""
    x = np.arange(256)
    if about.mode == "raw":
        return np.where(x <= OCCUPIED, x, UNKNOWN).astype(np.int8)
    p = (x if about.negate else 255 - x) / 255.0
    value = np.full(256, UNKNOWN, dtype=np.int8)
    value[p >= about.occupied_thresh] = OCCUPIED
    value[p <= about.free_thresh] = FREE
    if about.mode == "scale":
        between = (p > about.free_thresh) & (p < about.occupied_thresh)
        span = about.occupied_thresh - about.free_thresh
        graded = 100.0 * (p[between] - about.free_thresh) / span
        value[between] = np.floor(graded + 0.5)
    return value


def _trinary_pixels(data: SignedBytes) -> Bytes:
    pixels = np.full(data.shape, _UNKNOWN_PIXEL, dtype=np.uint8)
    pixels[data == FREE] = _FREE_PIXEL
    pixels[data == OCCUPIED] = _OCCUPIED_PIXEL
    return pixels


def _raw_pixels(data: SignedBytes) -> Bytes:
    return np.where((data < FREE) | (data > OCCUPIED), 255, data).astype(np.uint8)


def _find_image(yaml_file: Path, named: str) -> Path:
    image_file = yaml_file.parent / named
    try:
        if image_file.is_file():
            return image_file
    except OSError as cause:
        raise MapError(f"image: cannot be read ({cause.strerror})", file=yaml_file) from None
    beside = [yaml_file.with_suffix(suffix) for suffix in _IMAGE_SUFFIXES]
    for candidate in beside:
        if candidate.is_file():
            warnings.warn(
                f"{yaml_file}: the image {named!r} does not exist; {candidate.name!r} was read",
                MapWarning,
                stacklevel=3,
            )
            return candidate
    looked_for = ", ".join(str(f) for f in [image_file, *beside])
    raise MapError(f"image: no such file; searched for {looked_for}", file=yaml_file)


def _bare(file: Path) -> MapFile:
    if file.is_dir():
        raise MapError("is a folder; name a map's YAML file", file=file)
    if not file.is_file():
        raise MapError("no such file", file=file)
    return MapFile(
        image=file.name,
        resolution=_BARE_RESOLUTION,
        origin=(0.0, 0.0, 0.0),
        occupied_thresh=0.65,
        free_thresh=0.196,
    )


def _warn_of_bare_image(file: Path) -> None:
    """Warn that default values are used for a bare image."""
    warnings.warn(
        f"{file}: an image without a map YAML; taken as {_BARE_RESOLUTION} m a pixel, its lower "
        f"left corner at (0, 0), occupied from 0.65 on, free up to 0.196",
        MapWarning,
        stacklevel=3,
    )


def _warn_of_lost_unknowns(file: Path, about: MapFile, lightness: Bytes) -> None:
    """Warn if the shade that map savers write for unknown is read as free."""
    usual = about.mode == "trinary" and not about.negate
    if not usual or _occupancy_of_lightness(about)[_UNKNOWN_PIXEL] != FREE:
        return
    count = int(np.count_nonzero(lightness == _UNKNOWN_PIXEL))
    if count:
        warnings.warn(
            f"{file}: free_thresh {about.free_thresh:g} takes {count} pixels of shade 205, which "
            f"commonly means unknown, as free; 0.196 would keep them unknown",
            MapWarning,
            stacklevel=3,
        )


def _read_image(file: Path, pixel_limit: int) -> tuple[Bytes, Booleans]:
    """Lightness and full opacity (rows, cols) of an image, first row on top."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(file, formats=_DECODERS)
        with image:
            width, height = image.size
            if width * height > pixel_limit:
                raise MapError(
                    f"{width} x {height} pixels are more than the limit of {pixel_limit}", file=file
                )
            if not (width and height):
                raise MapError(f"an image of {width} x {height} pixels contains no map", file=file)
            if image.format == "PNG" and (missing := missing_rows(file)):
                raise MapError(
                    f"the image is damaged: {missing} of {height} rows are missing", file=file
                )
            if image.format == "PPM" and (surplus := surplus_bytes(file, image)):
                warnings.warn(
                    f"{file}: {surplus} bytes behind the last pixel were left out",
                    MapWarning,
                    stacklevel=3,
                )
            return _lightness_and_opacity(image)
    except Image.DecompressionBombError:
        raise MapError(f"more pixels than the limit of {pixel_limit}", file=file) from None
    except UnidentifiedImageError:
        raise MapError("not an image in PGM, PNG, BMP or JPEG", file=file) from None
    except (OSError, SyntaxError, ValueError, EOFError, struct.error) as cause:
        raise MapError(f"the image is damaged or cannot be read ({cause})", file=file) from cause


def _lightness_and_opacity(image: Image.Image) -> tuple[Bytes, Booleans]:
    if image.mode.startswith("I"):  # 16 bits a pixel
        deep = np.asarray(image, dtype=np.int64)
        lightness = np.clip((deep + 128) // 257, 0, 255).astype(np.uint8)
        return lightness, np.ones(lightness.shape, dtype=np.bool_)
    if image.has_transparency_data:
        colours = image.convert("RGBA")
        opaque = np.asarray(colours.getchannel("A")) == 255
        return np.asarray(colours.convert("RGB").convert("L")), opaque
    lightness = np.asarray(image.convert("L"))
    return lightness, np.ones(lightness.shape, dtype=np.bool_)
