"""Language files that come with the package: one TOML file each, of texts by key."""
