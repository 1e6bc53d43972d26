"""Signals out of sensors."""
