"""Rides and their measures, and scores of perception on recordings.

Drawing is not imported here; see ``cohelm.evaluation.perception.film``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
