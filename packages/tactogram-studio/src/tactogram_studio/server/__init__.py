"""The server: application, guard, certificates, connections."""
