"""Via points and reports of wishes, compared with values derived by hand."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.floors import problem, room

from cohelm.errors import TooManyWishes
from cohelm.geometry import transform
from cohelm.messages import Wish
from cohelm.planning.grid_search.via_points import MAX_LAYERS
from cohelm.planning.planners.wishes import (
    chains_of,
    has_wishes,
    on_grid,
    price_of,
    report_wishes,
    wished_line,
)

LINE = np.array([[1.0, 3.0], [5.0, 3.0], [9.0, 3.0]])


def wishing(*wishes):
    return replace(problem(room(10, 6), (1.0, 3.0), (9.0, 3.0)), wishes=wishes)


def attract(*points):
    return Wish(points=np.array(points))


def stroke(*points):
    return Wish(kind="stroke", points=np.array(points))


def said(*wishes):
    return report_wishes(wishing(*wishes), LINE, extra_length=0.0, extra_cost=0.0)


def test_says_the_closest_distance_to_every_point():
    wishes = said(attract([2.0, 4.0], [5.0, 3.0]), attract([11.0, 3.0]))
    assert wishes.closest.tolist() == [1.0, 0.0, 2.0]


def test_says_the_mean_distance_of_a_stroke():
    # Its distance rises evenly from 0 to 2 m.
    assert said(stroke([2.0, 3.0], [6.0, 5.0])).along == pytest.approx([1.0])
    assert said(stroke([2.0, 3.5], [6.0, 3.5]), stroke([4.0, 3.0])).along == pytest.approx([0.5, 0])


def test_says_how_far_zones_are_and_how_deep_the_path_is_in_them():
    zones = (
        Wish(kind="avoid", points=np.array([[5.0, 5.0]]), radius=0.5),
        Wish(kind="avoid", points=np.array([[5.0, 3.0]]), radius=0.5),
        Wish(kind="avoid", points=np.array([[4.0, 4.0], [6.0, 4.0]]), radius=0.25, hard=True),
        Wish(kind="avoid", points=np.array([[4.0, 1.0], [6.0, 1.0], [6.0, 3.4], [4.0, 3.4]])),
    )
    assert said(*zones).avoided == pytest.approx([1.5, -0.5, 0.75, -0.4], abs=1e-3)


def test_a_stroke_pays_for_the_mean_distance_along_its_length():
    (chain,) = chains_of(
        wishing(stroke([2.0, 4.0], [8.0, 4.0])),
        closeness=2.0,
        visiting=20.0,
        spacing=1.0,
        pieces=32,
    )
    assert chain.points[:, 0].tolist() == pytest.approx([2.5, 3.5, 4.5, 5.5, 6.5, 7.5])
    assert price_of(LINE, (chain,)) == pytest.approx(2.0 * 6.0 * 1.0)  # λ · length · distance
    (few,) = chains_of(
        wishing(stroke([2.0, 4.0], [8.0, 4.0])), closeness=2.0, visiting=20.0, spacing=1.0, pieces=3
    )
    assert len(few.points) == 3
    assert price_of(LINE, (few,)) == pytest.approx(12.0)


def test_a_line_pays_for_points_in_their_order():
    def price(*wishes):
        chains = chains_of(wishing(*wishes), closeness=3.0, visiting=20.0, spacing=1.0, pieces=32)
        return price_of(LINE, chains)

    there, back = [2.0, 3.0], [7.0, 3.0]
    assert price(attract(there, back)) == pytest.approx(0.0, abs=0.1)
    assert price(attract(back), attract(there)) == pytest.approx(0.0, abs=0.1)
    # The other way round, one of two 5 m apart is missed by all of it.
    assert price(attract(back, there)) == pytest.approx(3.0 * 5.0, abs=0.1)
    assert price() == 0.0


def test_strokes_take_fewer_pieces_where_there_are_many_wishes():
    long = [stroke([0.0, y], [100.0, y]) for y in (1.0, 2.0, 3.0)]
    chains = chains_of(
        wishing(attract([1.0, 1.0]), *long), closeness=2.0, visiting=20.0, spacing=1.0, pieces=32
    )
    counts = [len(chain.points) for chain in chains]
    assert np.prod([count + 1 for count in counts]) <= MAX_LAYERS
    assert min(counts[1:]) >= 3
    for chain in chains[1:]:
        assert chain.price * len(chain.points) == pytest.approx(2.0 * 100.0)
    with pytest.raises(TooManyWishes):
        chains_of(wishing(*long * 3), closeness=2.0, visiting=20.0, spacing=1.0, pieces=32)


@pytest.mark.parametrize("X_MG", [(0.0, 0.0, 0.0), (3.0, -2.0, 0.7)])
def test_chains_on_a_grid_are_its_cells(X_MG):
    grid = room(10, 6, X_MG=X_MG)
    task = replace(
        problem(grid, (1, 3), (9, 3)), wishes=(attract(*grid.centres([[4, 7], [9, 2]])),)
    )
    (chain,) = on_grid(chains_of(task, closeness=2.0, visiting=20.0, spacing=1.0, pieces=9), grid)
    assert chain.points == pytest.approx(np.array([[4.0, 7.0], [9.0, 2.0]]))


def test_the_wished_line_runs_through_everything_in_the_order_given():
    task = wishing(attract([2, 4]), Wish(kind="avoid", points=[[0, 0]]), stroke([3, 4], [5, 5]))
    assert wished_line(task).tolist() == [[1, 3], [2, 4], [3, 4], [5, 5], [9, 3]]


def test_empty_wishes_and_zones_draw_nothing():
    assert not has_wishes(wishing(Wish(points=np.empty((0, 2)))))
    assert not has_wishes(wishing(Wish(kind="avoid", points=np.ones((1, 2)))))
    assert has_wishes(wishing(stroke([1.0, 1.0])))


def test_a_stroke_across_the_earth_is_reported_on_at_once():
    far = stroke([-1e7, 4.0], [1e7, 4.0])
    assert said(far).along[0] == pytest.approx(5e6, rel=0.01)


def test_reports_turn_with_the_map():
    X = np.array([5.0, -2.0, 0.7])
    wish = attract([2.0, 4.0])
    straight = said(wish)
    turned = report_wishes(
        wishing(replace(wish, points=transform(X, wish.points))),
        transform(X, LINE),
        extra_length=0.0,
        extra_cost=0.0,
    )
    assert turned.closest == pytest.approx(straight.closest)
