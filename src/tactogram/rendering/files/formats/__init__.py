"""Haptic file formats, one file or folder each; every module declares a ``FORMAT``."""
