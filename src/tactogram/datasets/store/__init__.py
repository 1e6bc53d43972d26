"""Store: recordings on disk."""
