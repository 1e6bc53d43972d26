"""Display families, one module each."""
