"""Tests and intervals that studies, evaluation and experiments share."""
