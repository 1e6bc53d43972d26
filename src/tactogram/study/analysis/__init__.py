"""What answers show: per design the test of the publication and the sound one, with interval and verdict."""

from tactogram.study.analysis.analysis import DESIGNS as DESIGNS
from tactogram.study.analysis.analysis import MARGINS as MARGINS
from tactogram.study.analysis.analysis import Analysis as Analysis
from tactogram.study.analysis.analysis import Plan as Plan
from tactogram.study.analysis.analysis import analyse as analyse
from tactogram.study.analysis.findings import EQUIVALENT as EQUIVALENT
from tactogram.study.analysis.findings import NOT_SHOWN as NOT_SHOWN
from tactogram.study.analysis.findings import SHOWN as SHOWN
from tactogram.study.analysis.findings import UNDECIDED as UNDECIDED
from tactogram.study.analysis.findings import Finding as Finding
from tactogram.study.analysis.findings import Section as Section
