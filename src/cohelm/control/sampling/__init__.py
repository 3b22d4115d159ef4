"""Sampled candidate trajectories, for passages that a gradient method would not find.

``sampler`` is the entrance. ``search`` tries the arcs of ``arc_table``, each by ``rollout``, with
the inputs of ``arc_inputs``. ``candidates`` tells on which sides a trajectory passes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
