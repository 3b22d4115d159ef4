"""Sections of models by an independent reader, web-ifc, beside ours; run by hand.

    npm install --prefix FOLDER web-ifc
    python -m tests.buildings.compare_web_ifc FOLDER MODEL.ifc ...

For each storey: how many of the cells of 2 cm that walls and other solids (at the heights of the
map) or slabs touch for one reader, are touched within 2 cm for the other one too.
"""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from scipy import ndimage

from cohelm.buildings.ifc_file import meshes, open_ifc
from cohelm.buildings.ifc_storeys import BAND, _bodies, _by_height
from cohelm.buildings.sections import Mesh, covered_cells, touched_cells
from cohelm.buildings.storey import unknown_grid

CELL = 0.02


def web_ifc_meshes(folder, file):
    """Meshes by entity number; vertices of one place are one vertex, as in ours."""
    script = Path(__file__).with_name("web_ifc.mjs")
    command = ["node", str(script), str(file.resolve())]
    output = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    parts = {}
    for line in output.splitlines():
        if line.startswith("["):
            number, vertices, faces = json.loads(line)
            corners = np.reshape(vertices, (-1, 3))[np.array(faces, dtype=np.int64)]
            if len(faces):
                parts.setdefault(number, []).append(corners)
    found = {}
    for number, triangles in parts.items():
        corners = np.round(np.concatenate(triangles), 5)
        vertices, faces = np.unique(corners, axis=0, return_inverse=True)
        found[number] = Mesh(vertices=vertices, faces=faces.reshape(-1, 3).astype(np.int64))
    return found


def agreement(one, other):
    """Share of the cells of two masks (rows, cols) that the other one has within one cell."""
    near = [ndimage.binary_dilation(each, np.ones((3, 3))) for each in (one, other)]
    wrong = np.count_nonzero(one & ~near[1]) + np.count_nonzero(other & ~near[0])
    return 1.0 - wrong / max(np.count_nonzero(one | other), 1)


def compare(folder, file):
    model = open_ifc(file)
    products = model.model.by_type("IfcElement")
    ours = meshes(model, products, lambda elements, _: iter(elements))
    theirs = web_ifc_meshes(folder, file)
    common = [each for each in products if each.id() in ours and each.id() in theirs]
    alone = Counter(
        each.is_a() for each in products if (each.id() in ours) != (each.id() in theirs)
    )
    sys.stdout.write(f"{file.stem}: {len(common)} bodies; by one reader only: {dict(alone)}\n")
    bodies = [_bodies(common, found) for found in (ours, theirs)]
    spaces = model.model.by_type("IfcSpace")
    every = _bodies([*products, *spaces], {**ours, **meshes(model, spaces, lambda e, _: iter(e))})
    for level in _by_height(model, every):
        low, high = level.floor + BAND[0], level.floor + BAND[1]
        corners = np.concatenate([mesh.bounds[:, :2] for mesh in bodies[0].solids])
        grid = unknown_grid(corners, CELL, level.name, file)
        solid, floor = [], []
        for each in bodies:
            near = [m for m in each.solids if m.bounds[0, 2] < high and m.bounds[1, 2] > low]
            solid.append(touched_cells(near, grid, low, high))
            z = each.floors[:, :, 2]
            flat = (z.min(axis=1) > level.floor - 0.1) & (z.max(axis=1) < level.floor + 0.05)
            floor.append(covered_cells(each.floors[flat], grid))
        figures = f"solids {agreement(*solid):.5f} of {np.count_nonzero(solid[0])} cells, "
        figures += f"slabs {agreement(*floor):.5f} of {np.count_nonzero(floor[0])}"
        sys.stdout.write(f"  {level.name}: {figures}\n")


if __name__ == "__main__":
    for name in sys.argv[2:]:
        compare(sys.argv[1], Path(name))
