"""Logs of receivers, boards and recorders."""
