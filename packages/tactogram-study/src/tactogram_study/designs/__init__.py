"""Study designs, one file or folder each, discovered without a list."""

from tactogram_study.designs.catalogue import designs as designs, find_design as find_design
from tactogram_study.designs.design import Design as Design
