"""Importers of recordings of one's own, one module each."""
