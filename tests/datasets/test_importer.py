"""Importers by name."""

from tactogram.datasets.importer import importers


def test_every_importer_says_what_it_is():
    found = importers()
    assert set(found) >= {"folder", "lmt108", "cluster", "biotac_slide", "vibviz", "hatt", "haptex", "cdplab"}
    for importer in found.values():
        assert importer.TITLE
        assert importer.LICENCE
        assert importer.DESCRIPTION
