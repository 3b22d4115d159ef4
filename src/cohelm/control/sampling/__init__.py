"""Sampled candidate trajectories, for passages that a gradient method would not find.

``sampler`` is the entrance. ``search`` tries the arcs of ``arc_table``, each by ``rollout``, with
the inputs of ``arc_inputs``. ``candidates`` tells on which sides a trajectory passes.
"""

from cohelm.control.sampling.sampler import CandidateTrajectories, Sampling, evaluate, sample

__all__ = ["CandidateTrajectories", "Sampling", "evaluate", "sample"]
