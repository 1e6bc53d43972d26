"""The store: recordings on disk."""
