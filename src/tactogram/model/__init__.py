"""Interface between models and the rest of the package: conditions, examples and protocols.

A model implements `Learner`, and `Generator`, `Classifier` or `Predictor`; the other protocols are optional.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
