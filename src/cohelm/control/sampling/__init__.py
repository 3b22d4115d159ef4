"""Sampled candidate trajectories, for passages that a gradient method would not find."""

from cohelm.control.sampling.candidates import CandidateTrajectories
from cohelm.control.sampling.sampler import PreparedSampler, TrajectorySampler

__all__ = ["CandidateTrajectories", "PreparedSampler", "TrajectorySampler"]
