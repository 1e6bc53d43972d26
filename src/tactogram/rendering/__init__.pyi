from .displays.catalogue import (
    MotionBlock as MotionBlock,
    StreamDrive as StreamDrive,
    display_family as display_family,
    open_display as open_display,
    shipped as shipped,
)
from .displays.display import (
    Display as Display,
)
from .displays.response import (
    write_response as write_response,
)
from .drive.axes import (
    combined as combined,
    to_one_axis as to_one_axis,
)
from .drive.fit import (
    Drive as Drive,
    fit as fit,
)
from .drive.friction_calibration import (
    FrictionCalibration as FrictionCalibration,
    read_calibrations as read_calibrations,
)
from .drive.level_scaling import (
    without_constant as without_constant,
)
from .drive.modulation import (
    CarrierSettings as CarrierSettings,
    carrier_of as carrier_of,
)
from .drive.path_playback import (
    OVERSAMPLED as OVERSAMPLED,
    band_limited as band_limited,
    copy_count as copy_count,
    play_loop as play_loop,
)
from .drive.safety import (
    bounds as bounds,
    fade_window as fade_window,
    safe as safe,
)
from .drive.strength import (
    StrengthSettings as StrengthSettings,
    strength as strength,
)
from .embedded.noise_header import (
    one_axis as one_axis,
)
from .files.analysis import (
    HIGHEST_HZ as HIGHEST_HZ,
    carrier as carrier,
    envelope_of as envelope_of,
    events_of as events_of,
)
from .files.catalogue import (
    file_name as file_name,
    haptic_format as haptic_format,
    haptic_formats as haptic_formats,
    haptic_labels as haptic_labels,
    haptic_suffixes as haptic_suffixes,
)
from .files.conversion import (
    GRAVITY as GRAVITY,
    write_haptic as write_haptic,
)
from .files.documents import (
    DocumentHeader as DocumentHeader,
)
from .files.events import (
    JUMP_S as JUMP_S,
    PHONE_HZ as PHONE_HZ,
    PULSE_S as PULSE_S,
    Events as Events,
    Part as Part,
    Transient as Transient,
    densified as densified,
    joined as joined,
    thinned as thinned,
)
from .files.reading import (
    HapticFile as HapticFile,
    read_haptic as read_haptic,
)
from .level import (
    Level as Level,
    parse_level as parse_level,
)
from .motion.finger_path import (
    FINGER_STATES as FINGER_STATES,
    FingerTracker as FingerTracker,
)
from .motion.finger_state import (
    FingerState as FingerState,
    MixWeights as MixWeights,
    MotionSample as MotionSample,
    MotionSettings as MotionSettings,
    MotionSource as MotionSource,
    Tap as Tap,
)
from .motion.recorded_motion import (
    MotionFile as MotionFile,
    SimulatedHand as SimulatedHand,
)
from .photo_relief import (
    SPEED_MM_S as SPEED_MM_S,
    WIDTH_MM as WIDTH_MM,
    photo_to_touch as photo_to_touch,
    slopes_of as slopes_of,
)
from .ready_effects import (
    effect as effect,
    effects as effects,
)
