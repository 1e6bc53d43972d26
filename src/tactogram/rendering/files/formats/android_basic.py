"""Android 16's envelope with sharpness: the calls of `VibrationEffect.BasicEnvelopeBuilder` as JSON.

``initialSharpness`` is of ``setInitialSharpness``, each entry of ``controlPoints`` of a call of
``addControlPoint(intensity, sharpness, durationMillis)``; the last intensity is 0. Each phone turns intensity and
sharpness into its own amplitudes and frequencies, in a way that the file does not state.
"""

from tactogram.rendering.files.control_points import EnvelopeBuilder
from tactogram.rendering.files.events import FrequencySpan

SPAN = FrequencySpan(65.0, 300.0)
"""Frequencies that sharpness is taken for, and intensity for amplitude. A choice: those of AHAP's sharpness."""
BUILDER = EnvelopeBuilder(
    "Android basic envelope (API 36)",
    "android-basic-envelope",
    ("intensity", "sharpness", "durationMillis"),
    "initialSharpness",
    SPAN,
)
FORMAT = BUILDER.haptic_format(
    "android_basic",
    {"android (faster changes)": "android", "android_envelope (any frequency)": "android_envelope"},
)
