"""One module for each page; each has ``add(studio)``, which registers its routes."""
