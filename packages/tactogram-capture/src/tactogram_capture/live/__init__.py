"""Live recognition of a source."""
