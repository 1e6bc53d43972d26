"""Simulator: computed surfaces, touched by a computed finger. Its results are marked simulated."""

from tactogram.datasets.simulate.sets import (
    make as make,
    simulated_sets as simulated_sets,
    surface_photographs as surface_photographs,
    tasks as tasks,
)
from tactogram.datasets.simulate.stroke import RecordingTask as RecordingTask
from tactogram.datasets.simulate.studies import (
    RATERS as RATERS,
    SimulatedStudyData as SimulatedStudyData,
    study as study,
)
