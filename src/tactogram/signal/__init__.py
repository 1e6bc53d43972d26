"""Tactile signals: types, filters, synthesis, perception; files are read and written by `tactogram.signal.io`.

Only the types are imported here: scipy's filters take longer to load than a stimulus to play.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
