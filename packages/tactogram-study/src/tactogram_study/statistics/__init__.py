"""Tests and intervals of studies alone; those that evaluation has, too, are in `tactogram.statistics`."""
