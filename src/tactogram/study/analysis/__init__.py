"""What answers show: per design the test of the publication and the sound one, with interval and verdict."""

from tactogram.study.analysis.analysis import DESIGNS as DESIGNS
from tactogram.study.analysis.analysis import MARGINS as MARGINS
from tactogram.study.analysis.analysis import Analysis as Analysis
from tactogram.study.analysis.analysis import Plan as Plan
from tactogram.study.analysis.analysis import analyse as analyse
from tactogram.study.analysis.finding import EQUIVALENT as EQUIVALENT
from tactogram.study.analysis.finding import NOT_SHOWN as NOT_SHOWN
from tactogram.study.analysis.finding import SHOWN as SHOWN
from tactogram.study.analysis.finding import UNDECIDED as UNDECIDED
from tactogram.study.analysis.finding import Finding as Finding
from tactogram.study.analysis.finding import Section as Section
