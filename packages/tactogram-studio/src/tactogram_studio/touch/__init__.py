"""Textures for the page Touch: sources, tables for the browser, pictures, and shared pages."""
