"""The study editor."""
