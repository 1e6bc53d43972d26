"""Study designs, one file or folder each, discovered without a list."""

from tactogram.study.designs.catalogue import designs as designs
from tactogram.study.designs.catalogue import find_design as find_design
from tactogram.study.designs.design import Design as Design
