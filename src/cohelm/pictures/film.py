"""Frames as a moving picture: GIF by Pillow, MP4 where ffmpeg is installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
from PIL import Image

from cohelm.arrays import Bytes, Floats
from cohelm.errors import ConfigError
from cohelm.pictures import canvas

INTERVAL = 0.25
"""Of what is shown between two frames, s."""
SPEED_UP = 2.5
"""Played faster than life."""
WIDTH = 900
"""Of a frame, px."""
_LAST = 2000  # that the last frame stays, ms


def check_animation(file: Path) -> None:
    """Refuse a file that no animation can be written to, before the work is done.

    Raises:
        ConfigError: naming the option and what to do.
    """
    kind = file.suffix.lower()
    if kind not in {".gif", ".mp4"}:
        raise ConfigError(f"{file}: write an animation as .gif or .mp4", key="--animate")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError("an .mp4 needs ffmpeg, which is not here; write a .gif", key="--animate")
    canvas.check_folder(file, "--animate")


def write_film(
    frames: Iterator[Bytes], file: Path, *, sample: Bytes, shades: Floats | None = None
) -> None:
    """Write RGB images (height, width, 3), an ``INTERVAL`` apart, as .gif or .mp4.

    Args:
        frames: in the order of time, one or more.
        file: to be written, see :func:`check_animation`.
        sample: a frame whose colours are those of all.
        shades: (s, 3) further colours, 0…1, which it may not show.

    Raises:
        ConfigError: if the file cannot be written.
    """
    try:
        if file.suffix.lower() == ".gif":
            _write_gif(frames, _palette(sample, shades), file)
        else:
            _write_mp4(frames, file)
    except OSError as cause:
        raise canvas.not_written(file, "--animate", cause) from None


def _write_gif(frames: Iterator[Bytes], palette: Image.Image, file: Path) -> None:
    """One palette for all frames: colours do not flicker, and the file stays small."""
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    milliseconds = [round(1000.0 * INTERVAL / SPEED_UP)] * len(images)
    milliseconds[-1] = _LAST
    images[0].save(file, save_all=True, append_images=images[1:], duration=milliseconds, loop=0)


def _palette(frame: Bytes, shades: Floats | None) -> Image.Image:
    """256 colours of a frame and of further shades."""
    if shades is not None:
        picked = shades[np.linspace(0, len(shades) - 1, frame.shape[1]).astype(int)]
        colours = (picked * 255.0).astype(np.uint8)
        strip = np.broadcast_to(colours, (frame.shape[0] // 10, *colours.shape))
        frame = np.concatenate([frame, strip])
    return Image.fromarray(frame).quantize(
        256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
    )


def _write_mp4(frames: Iterator[Bytes], file: Path) -> None:
    first = next(frames)
    height, width = (length - length % 2 for length in first.shape[:2])  # H.264 wants even sides
    command = (
        f"ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {width}x{height} "
        f"-r {SPEED_UP / INTERVAL:g} -i - -pix_fmt yuv420p"
    )
    with subprocess.Popen([*command.split(), str(file)], stdin=subprocess.PIPE) as ffmpeg:
        if ffmpeg.stdin is not None:
            for frame in chain((first,), frames):
                ffmpeg.stdin.write(frame[:height, :width].tobytes())
            ffmpeg.stdin.close()
    if ffmpeg.returncode:
        raise ConfigError(f"{file}: ffmpeg could not write it; write a .gif", key="--animate")
