"""Splits that cannot leak."""
