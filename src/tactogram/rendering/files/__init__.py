"""Haptic file formats: a signal or events into what phones, headsets, browsers and gamepads play, and back."""

from tactogram.rendering.drive.axes import to_one_axis as to_one_axis
from tactogram.rendering.files.catalogue import (
    HapticFormat as HapticFormat,
    haptic_format as haptic_format,
    haptic_formats as haptic_formats,
)
from tactogram.rendering.files.conversion import write_haptic as write_haptic
from tactogram.rendering.files.documents import DocumentHeader as DocumentHeader
from tactogram.rendering.files.events import Events as Events
from tactogram.rendering.files.loss import (
    ConversionLoss as ConversionLoss,
    loss_between as loss_between,
    loss_sentence as loss_sentence,
)
from tactogram.rendering.files.reading import (
    HapticFile as HapticFile,
    check_file as check_file,
    read_haptic as read_haptic,
)
