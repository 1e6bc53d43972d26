"""Importers of published data sets and of plain folders, one module each."""
