"""Tests and intervals that studies, evaluation and experiments share."""

from tactogram.statistics.comparison import Comparison as Comparison
from tactogram.statistics.comparison import PairComparison as PairComparison
from tactogram.statistics.comparison import friedman_wilcoxon as friedman_wilcoxon
from tactogram.statistics.comparison import mann_whitney as mann_whitney
from tactogram.statistics.comparison import paired_t as paired_t
from tactogram.statistics.comparison import steel_dwass as steel_dwass
from tactogram.statistics.comparison import student_t as student_t
from tactogram.statistics.comparison import welch_t as welch_t
from tactogram.statistics.reliability import IntraclassCorrelation as IntraclassCorrelation
from tactogram.statistics.reliability import intraclass_correlation as intraclass_correlation
from tactogram.statistics.reliability import krippendorff_alpha as krippendorff_alpha
from tactogram.statistics.summary import GroupSummary as GroupSummary
from tactogram.statistics.summary import by_participant as by_participant
from tactogram.statistics.summary import summary as summary
