from .sampler import CandidateTrajectories, Sampling, evaluate, sample

__all__ = ["CandidateTrajectories", "Sampling", "evaluate", "sample"]
