"""Drawn haptic effects: tracks of an amplitude, a frequency and transients, their editing and their mix."""

from tactogram.rendering.effects.effect import Effect as Effect
from tactogram.rendering.effects.effect import Point as Point
from tactogram.rendering.effects.effect import Track as Track
from tactogram.rendering.effects.effect import Transient as Transient
from tactogram.rendering.effects.effect import mixed as mixed
from tactogram.rendering.effects.effect import track_of as track_of
from tactogram.rendering.effects.effect import track_of_signal as track_of_signal
from tactogram.rendering.effects.library import ready_effects as ready_effects
