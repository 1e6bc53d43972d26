"""Sessions: participants, answers and their store."""
