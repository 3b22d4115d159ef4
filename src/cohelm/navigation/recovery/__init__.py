"""Recovery of rides that make no progress: progress checker, stages, rear clearance."""
