"""Live output to displays: streams that follow a finger, playback of drives, carriers at a transducer's resonance."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
