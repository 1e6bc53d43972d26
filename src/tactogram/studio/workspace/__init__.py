"""The studio's workspace: folder, shelf of results, uploads."""
