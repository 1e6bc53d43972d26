"""Kinds of tasks: one module each, which defines ``KIND``."""
