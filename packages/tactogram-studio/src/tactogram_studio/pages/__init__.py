"""Pages of the studio, one folder each."""
