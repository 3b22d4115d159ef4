"""Write frames as an animation: GIF by Pillow, MP4 where ffmpeg is installed."""

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
from cohelm.plotting import canvas

INTERVAL = 0.25
"""Time of the ride between two frames, s."""
WIDTH = 900
"""Width of a frame, px."""
_LAST = 2000
"""Duration of the last frame, ms."""


def check_animation(file: Path) -> None:
    """Refuse a file that cannot be written as an animation, before the work.

    Raises:
        ConfigError: naming the option and what to do.
    """
    kind = file.suffix.lower()
    if kind not in {".gif", ".mp4"}:
        raise ConfigError(f"{file}: write an animation as .gif or .mp4", key="--animate")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError(
            "an .mp4 needs ffmpeg, which is not installed; write a .gif", key="--animate"
        )
    canvas.check_folder(file, "--animate")


def titled(title: str, speed_up: float) -> str:
    """Title of an animation, with its playback speed unless that is real time."""
    return title if speed_up == 1.0 else f"{title}   ({speed_up:g} × real time)".lstrip()


def write_film(
    frames: Iterator[Bytes],
    file: Path,
    *,
    sample: Bytes,
    shades: Floats | None = None,
    speed_up: float = 1.0,
) -> None:
    """Write RGB images (height, width, 3), an ``INTERVAL`` apart, as .gif or .mp4.

    Args:
        frames: One or more, in the order of time.
        file: Animation to write, see :func:`check_animation`.
        sample: A frame with the colours of all frames.
        shades: (s, 3) further colours, 0…1.
        speed_up: Playback speed; 1 is real time.

    Raises:
        ConfigError: if the file cannot be written.
    """
    try:
        if file.suffix.lower() == ".gif":
            _write_gif(frames, _palette(sample, shades), file, speed_up)
        else:
            _write_mp4(frames, file, speed_up)
    except OSError as cause:
        raise canvas.not_written(file, "--animate", cause) from None


def _write_gif(frames: Iterator[Bytes], palette: Image.Image, file: Path, speed_up: float) -> None:
    """Use one palette for all frames: colours do not flicker, and the file stays small."""
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    milliseconds = [round(1000.0 * INTERVAL / speed_up)] * len(images)
    milliseconds[-1] = _LAST
    images[0].save(file, save_all=True, append_images=images[1:], duration=milliseconds, loop=0)


def _palette(frame: Bytes, shades: Floats | None) -> Image.Image:
    """Palette of 256 colours from a frame and further shades."""
    if shades is not None:
        picked = shades[np.linspace(0, len(shades) - 1, frame.shape[1]).astype(int)]
        colours = (picked * 255.0).astype(np.uint8)
        strip = np.broadcast_to(colours, (frame.shape[0] // 10, *colours.shape))
        frame = np.concatenate([frame, strip])
    return Image.fromarray(frame).quantize(
        256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
    )


def _write_mp4(frames: Iterator[Bytes], file: Path, speed_up: float) -> None:
    first = next(frames)
    height, width = (length - length % 2 for length in first.shape[:2])  # H.264 needs even sides
    command = (
        f"ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {width}x{height} "
        f"-r {speed_up / INTERVAL:g} -i - -pix_fmt yuv420p"
    )
    with subprocess.Popen([*command.split(), str(file)], stdin=subprocess.PIPE) as ffmpeg:
        if ffmpeg.stdin is not None:
            for frame in chain((first,), frames):
                ffmpeg.stdin.write(frame[:height, :width].tobytes())
            ffmpeg.stdin.close()
    if ffmpeg.returncode:
        raise ConfigError(f"{file}: ffmpeg could not write it; write a .gif", key="--animate")
