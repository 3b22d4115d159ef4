"""Sampled candidate trajectories, for passages that a gradient method would not find.

``sampler`` is the entrance. ``scene`` turns a problem into plain arrays, ``path_samples`` its path.
``search`` tries the arcs of ``arc_table``, each by ``rollout``: its inputs are in ``arc_inputs``,
its costs of walls, people and groups in ``interactions``. ``candidates`` tells on which sides a
trajectory passes.
"""

from cohelm.control.sampling.candidates import CandidateTrajectories
from cohelm.control.sampling.sampler import PreparedSampler, TrajectorySampler

__all__ = ["CandidateTrajectories", "PreparedSampler", "TrajectorySampler"]
