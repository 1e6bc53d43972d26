"""HJIF, the JSON form of MPEG's haptics (ISO/IEC 23090-31), which holds waveforms and events."""

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import has_key
from tactogram.rendering.files.formats.hjif.reading import MODALITIES, decode
from tactogram.rendering.files.formats.hjif.writing import HIGHEST_RATE, encode, encode_waveform

FORMAT = HapticFormat(
    name="hjif",
    title="HJIF (MPEG)",
    suffix=".hjif",
    holds="waveform",
    encode=encode,
    encode_waveform=encode_waveform,
    decode=decode,
    recognise=has_key("perceptions"),
    instead=".wav",
    modalities=MODALITIES,
    highest_rate=HIGHEST_RATE,
)
