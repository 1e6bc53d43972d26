"""The page Send: results to displays, files and devices."""
