"""Measures, pictures, result tables and the report."""
