"""The studio's workspace: folder, kept results, uploads."""
