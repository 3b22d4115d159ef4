"""Process that makes triangle meshes: a damaged model can crash the geometry library.

Run as ``python -m cohelm.buildings.ifc_shapes MODEL`` with entity numbers on standard input; each
shape is a pickled (entity number, vertices, faces) on standard output, and None ends them.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import ifcopenshell
import ifcopenshell.geom
import numpy as np

from cohelm.errors import BuildingError

_KERNEL: Literal["hybrid-cgal-simple-opencascade"] = "hybrid-cgal-simple-opencascade"
"""Geometry kernel: the slower Open CASCADE only for what the faster one cannot make."""


def shapes(file: Path, numbers: Sequence[int]) -> Iterator[tuple[int, Any, Any]]:
    """Entity number, vertices (v, 3), m, and faces (f, 3) of products that have a readable body.

    Raises:
        BuildingError: if the geometry library crashes.
    """
    command = [sys.executable, "-m", "cohelm.buildings.ifc_shapes", str(file)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL) as child:
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            pickle.dump(list(numbers), child.stdin)
            child.stdin.close()
            while (shape := pickle.load(child.stdout)) is not None:
                yield shape
        except (EOFError, pickle.UnpicklingError, BrokenPipeError):
            problem = "a damaged model: ifcopenshell crashes on its geometry"
            raise BuildingError(problem, file=file) from None
        finally:
            child.kill()


def _make(file: str) -> None:
    model: Any = ifcopenshell.open(file)
    products = [model.by_id(number) for number in pickle.load(sys.stdin.buffer)]
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    iterator: Any = ifcopenshell.geom.iterator(
        settings, model, 1, include=products, geometry_library=_KERNEL
    )
    more = bool(products) and iterator.initialize()
    while more:
        shape = iterator.get()
        vertices = np.array(shape.geometry.verts).reshape(-1, 3)
        faces = np.array(shape.geometry.faces, dtype=np.int64).reshape(-1, 3)
        pickle.dump((shape.id, vertices, faces), sys.stdout.buffer)
        more = iterator.next()
    pickle.dump(None, sys.stdout.buffer)
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    _make(sys.argv[1])
