"""Places to drive a laser through, and people who walk there."""

import numpy as np

from .rays import Laser, box, room


def furnished(beams=720, noise=0.01, seed=0):
    """(a laser in a room of 12 × 9 m with boxes along its walls, posts and legs of tables)."""
    rng = np.random.default_rng(seed)
    boxes = [
        box(x, side * rng.uniform(2.2, 3.6), rng.uniform(0.3, 0.8), rng.uniform(0.0, 1.5))
        for x in (-4.0, -1.5, 1.0, 3.5)
        for side in (-1.0, 1.0)
    ]
    laser = Laser(grid=room(12.0, 9.0), segments=np.concatenate(boxes), beams=beams, noise=noise)
    where = rng.uniform([-5.0, 1.2], [5.0, 3.5], (12, 2)) * rng.choice([[1, 1], [1, -1]], 12)
    return laser, np.column_stack([where, np.full(12, 0.03)])


def corridor(doors, noise=0.01):
    """A laser in a corridor 40 m long and 2.2 m wide, its ends out of sight."""
    rng, segments = np.random.default_rng(0), []
    for side in (-1.1, 1.1):
        x = -20.0
        while doors and x < 20.0:
            at, deep = x + rng.uniform(2.0, 4.0), side * 1.11
            segments += [[x, side, at, side], [at, side, at, deep], [at, deep, at + 0.9, deep]]
            x = at + 0.9
            segments.append([x, deep, x, side])
        if not doors:
            segments.append([x, side, 20.0, side])
    return Laser(grid=room(60.0, 20.0), segments=np.array(segments), beams=720, noise=noise)


def walkers(count, seed=0):
    """Legs of so many people who walk to and fro at up to 1 m/s, at each time."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform([-4.0, -2.0], [4.0, 2.0], (count, 2))
    course, phase = rng.uniform(0.0, 2.0 * np.pi, (2, count))
    along = np.stack([np.cos(course), np.sin(course)], axis=-1)

    def at(time):
        walked = 2.0 * np.sin(0.5 * time + phase)
        stride = 0.05 + 0.2 * np.abs(np.sin(5.0 * time + phase))
        legs = [middle + (walked + side * stride)[:, None] * along for side in (-1.0, 1.0)]
        return np.column_stack([np.concatenate(legs), np.full(2 * count, 0.06)])

    return at
