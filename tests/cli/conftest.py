import numpy as np
import pytest
import yaml
from PIL import Image

from cohelm.cli.app import status


@pytest.fixture
def cohelm(capsys):
    """Runs a command in this process: (exit status, standard output, standard error)."""

    def _cohelm(*arguments):
        code = status([str(each) for each in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return _cohelm


@pytest.fixture
def room(tmp_path):
    """A map file of a room of 10 × 6 m, its lower left corner at (−5, −3)."""
    pixels = np.full((60, 100), 254, dtype=np.uint8)
    pixels[[0, -1]] = 0
    pixels[:, [0, -1]] = 0
    Image.fromarray(pixels).save(tmp_path / "room.pgm")
    return write_map(tmp_path / "room.yaml")


def write_map(file, **changes):
    given = {
        "image": "room.pgm",
        "resolution": 0.1,
        "origin": [-5.0, -3.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
        **changes,
    }
    file.write_text(yaml.safe_dump({k: v for k, v in given.items() if v is not None}))
    return file


@pytest.fixture
def another_map(tmp_path):
    """Writes the room's YAML with changes."""
    return lambda **changes: write_map(tmp_path / "changed.yaml", **changes)


def mask(folder, name, pixels, **changes):
    """A mask over the room of 10 × 6 m."""
    Image.fromarray(pixels).save(folder / f"{name}.pgm")
    about = {
        "image": f"{name}.pgm", "resolution": 0.1, "origin": [-5.0, -3.0, 0.0], "negate": 0,
        "occupied_thresh": 0.65, "free_thresh": 0.196, "mode": "scale", **changes,
    }  # fmt: skip
    file = folder / f"{name}.yaml"
    file.write_text(yaml.safe_dump(about))
    return file
