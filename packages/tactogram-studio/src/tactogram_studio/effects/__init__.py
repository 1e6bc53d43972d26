"""Drawn haptic effects: tracks of an amplitude, a frequency and transients, their editing and their mix."""

from tactogram_studio.effects.editing import ready_effects as ready_effects
from tactogram_studio.effects.effect import (
    Effect as Effect,
    Point as Point,
    Track as Track,
    Transient as Transient,
    mixed as mixed,
    track_of as track_of,
    track_of_signal as track_of_signal,
)
