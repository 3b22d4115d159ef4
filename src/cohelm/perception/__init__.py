"""Perception: scans and clouds → detections → people → groups and predictions; live obstacles."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
