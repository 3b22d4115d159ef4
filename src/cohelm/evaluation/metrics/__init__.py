"""Measures of a ride, one definition each: SI units, distances from surface to surface."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
