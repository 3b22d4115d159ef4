import numpy as np

from cohelm.planar_fit import add_row, newton_step


def test_one_step_solves_the_weighted_least_squares_of_its_rows():
    """As numpy's solver of the stacked rows does; rows without weight do not count."""
    rng = np.random.default_rng(3)
    angle, turn, e = rng.uniform(-3.0, 3.0, 20), rng.normal(size=20), rng.normal(size=20)
    weight = np.where(np.arange(20) < 3, 0.0, rng.uniform(0.1, 2.0, 20))
    H, g = np.zeros((3, 3)), np.zeros(3)
    for row in zip(np.cos(angle), np.sin(angle), turn, e, weight, strict=True):
        add_row(H, g, *row)
    rows = np.sqrt(weight)[:, None] * np.column_stack([np.cos(angle), np.sin(angle), turn])
    expected = np.linalg.lstsq(rows, -np.sqrt(weight) * e, rcond=None)[0]
    np.testing.assert_allclose(newton_step(H, g), expected, atol=1e-9)


def test_points_on_a_moved_wall_and_corner_give_the_motion():
    """Two perpendicular walls fix all three unknowns; small turns are linear to their square."""
    shift, turn = np.array([0.02, -0.03]), 1e-4
    wall = np.linspace(0.5, 2.0, 8)
    points = [(x, 1.0, 0.0, 1.0) for x in wall] + [(2.0, y, 1.0, 0.0) for y in wall]
    H, g = np.zeros((3, 3)), np.zeros(3)
    for x, y, nx, ny in points:
        seen = np.array([x, y]) + shift + turn * np.array([-y, x])
        add_row(H, g, nx, ny, ny * x - nx * y, float((seen - (x, y)) @ (nx, ny)), 1.0)
    np.testing.assert_allclose(newton_step(H, g), [-shift[0], -shift[1], -turn], atol=1e-12)
