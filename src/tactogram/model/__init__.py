"""Interface between models and the rest of the package: `Model`, the base class of all, conditions and examples."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
