"""Compiler options of functions that only fill arrays which they are given.

Such a function owns no array, so it need not count references, which took more than half of the
time of a search: all tables of a scene are counted at every call.
"""

KERNEL = {"cache": True, "error_model": "numpy", "_nrt": False}
"""For ``numba.njit``; such a function must not create arrays, nor assign one array to another."""
INNER = {**KERNEL, "forceinline": True}
"""For functions inside a rollout: a call would copy all tables of the scene."""
