"""Local planners: one objective, its terms and barriers, and the planners that minimise it.

The entrance is ``ss_mpc_dcbf``, the default planner. One plan is made in these steps:

1. ``validation`` checks the problem, ``warm_start`` estimates the current input, ``scene`` makes
   the tables of the problem and ``stack`` those of the objective.
2. ``sampling`` searches trajectories, ``sqp`` improves the best of different homotopy classes.
3. ``candidates`` adds the terms of the choice to the ``objective`` of each.
4. ``verification`` accepts the cheapest safe one, or the planner brakes (``trajectories``).
5. The first input becomes the command; ``planner_memory`` keeps the sides on which people are
   passed, so that the next plan does not change its mind.

``api`` has the interface, ``terms`` the terms and barriers, ``baselines`` the published planners
for comparison.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
