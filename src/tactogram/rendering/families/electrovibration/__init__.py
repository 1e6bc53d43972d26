"""Electrovibration: a friction coefficient as the amplitude of a carrier, by the square law."""

from tactogram.rendering.displays.family import DisplayFamily
from tactogram.rendering.families.electrovibration.friction import Settings as Settings
from tactogram.rendering.families.electrovibration.friction import drive as drive
from tactogram.rendering.families.electrovibration.friction import friction as friction
from tactogram.rendering.families.electrovibration.friction import voltage as voltage
from tactogram.rendering.families.electrovibration.path_stream import (
    ElectrovibrationStream as ElectrovibrationStream,
)
from tactogram.rendering.families.electrovibration.path_stream import SurfaceStream

FAMILY = DisplayFamily(
    name="electrovibration",
    settings=Settings,
    drive=drive,
    renders="friction",
    stream_surface=SurfaceStream,
    measured_by="`tactogram calibrate` fits it to a person",
    calibrated=True,
    hazard=(
        "A voltage touches a person, up to {peak:.3g} V here: play it only through an amplifier that limits the "
        "current. Limits in software do not replace one."
    ),
    close_up_s=0.05,
)
