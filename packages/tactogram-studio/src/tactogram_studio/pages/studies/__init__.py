"""The page Studies, and what an experimenter sees of a session."""
