"""The page Make."""
