"""Simulator: computed surfaces, touched by a computed finger. Its results are marked simulated."""

from tactogram.datasets.simulate.sets import make as make
from tactogram.datasets.simulate.sets import simulated_sets as simulated_sets
from tactogram.datasets.simulate.sets import surface_photographs as surface_photographs
from tactogram.datasets.simulate.sets import tasks as tasks
from tactogram.datasets.simulate.stroke import RecordingTask as RecordingTask
from tactogram.datasets.simulate.studies import RATERS as RATERS
from tactogram.datasets.simulate.studies import SimulatedStudyData as SimulatedStudyData
from tactogram.datasets.simulate.studies import study as study
