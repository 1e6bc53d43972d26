"""Display families, one file or folder each; every module declares a ``FAMILY``."""
