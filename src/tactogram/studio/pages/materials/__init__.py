"""The page Materials."""
