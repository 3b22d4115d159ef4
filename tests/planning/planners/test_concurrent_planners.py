"""Planners in several threads do not affect each other."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from tests.planning.floors import problem, room

from cohelm.arrays import identical
from cohelm.messages import LiveObstacles
from cohelm.planning import SoftVia
from cohelm.planning.grid_search.shortest_path import forget_workspace


def questions():
    """On three maps, of which two have the same size, with and without a wish and a live obstacle.

    Maps of one size share the search's workspace, and the costmaps of two maps are kept.
    """
    stands = np.ones((6, 6), dtype=np.uint8)
    for width, boxes in ((12, [(4, 3, 8, 6)]), (12, [(3, 2, 6, 7)]), (15, [(5, 3, 9, 8)])):
        grid = room(width, 9, boxes=boxes)
        for prefer in ((), [(6.0, 7.8)]):
            for corner in ((15, 30), (60, 45)):
                live = LiveObstacles(corner=corner, occupied=stands, version=1)
                yield problem(grid, (1.5, 4.5), (10.5, 4.5), prefer=prefer, live=live)


def test_planners_in_threads_and_in_turns_answer_as_each_alone():
    asked, planner = list(questions()), SoftVia()
    alone = []
    for each in asked:
        forget_workspace()
        alone.append(planner.plan(each))
    in_turns = [planner.plan(each) for each in reversed(asked)][::-1]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(planner.plan, asked * 3))
    assert identical(alone, in_turns)
    assert identical(alone * 3, together)
    assert len({path.length for path in alone}) > 4
