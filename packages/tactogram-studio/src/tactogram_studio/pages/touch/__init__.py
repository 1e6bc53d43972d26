"""The page Touch: textures under the hand."""
