"""Android 16's envelope with frequency: the calls of `VibrationEffect.WaveformEnvelopeBuilder` as JSON.

``initialFrequencyHz`` is of ``setInitialFrequencyHz``, each entry of ``controlPoints`` of a call of
``addControlPoint(amplitude, frequencyHz, durationMillis)``. An amplitude of 1 is the strongest that the phone can do.
"""

from tactogram.rendering.files.control_points import EnvelopeBuilder

BUILDER = EnvelopeBuilder(
    "Android waveform envelope (API 36)",
    "android-waveform-envelope",
    ("amplitude", "frequencyHz", "durationMillis"),
    "initialFrequencyHz",
)
FORMAT = BUILDER.haptic_format(
    "android_envelope", {"android (a strength every 10 ms, at the phone's own frequency)": "android"}
)
