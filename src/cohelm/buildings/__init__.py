"""Buildings: storeys with their maps, rooms and doors, read from IFC models and Nav2 maps."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
