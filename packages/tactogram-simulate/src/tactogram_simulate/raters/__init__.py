"""Simulated raters with biases and noise, who score what they touch and see by a published rule.

No model, feature or evaluation may import this (by an import contract): they must not know the rater.
"""

from tactogram_simulate.raters.rules import TouchCues as TouchCues
from tactogram_simulate.raters.scoring import (
    SimulatedRater as SimulatedRater,
    draw_people as draw_people,
    score_images as score_images,
    score_plates as score_plates,
    score_surfaces as score_surfaces,
    score_together as score_together,
    score_vibrations as score_vibrations,
    sight_weight as sight_weight,
    surface_cues as surface_cues,
)
