"""Measures of how similar generated signals are to real ones: one function each, with its formula and source.

`signal_measures` returns the measures of two sets of signals; the others are of points in an embedding, of copies and
of labels. ``docs/measures.md`` lists what each one detects and what it is blind to.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
