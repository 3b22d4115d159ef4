"""Messages between pages and chair: one union for each direction, and one version.

Every message is one JSON object, identified by its ``type``. Units are SI, the frame is the map's
(REP-103). Every number and every length in a message from a page is bounded: ``FromPage`` rejects
all else before it is used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
