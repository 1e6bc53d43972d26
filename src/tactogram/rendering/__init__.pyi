from .displays.catalogue import (
    display_family as display_family,
    open_display as open_display,
    shipped as shipped,
)
from .displays.display import (
    Display as Display,
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
    read_calibrations as read_calibrations,
)
from .drive.level_scaling import (
    without_constant as without_constant,
)
from .drive.modulation import (
    carrier_of as carrier_of,
)
from .drive.path_playback import (
    OVERSAMPLED as OVERSAMPLED,
    copy_count as copy_count,
)
from .drive.strength import (
    StrengthSettings as StrengthSettings,
    strength as strength,
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
from .photo_relief import (
    SPEED_MM_S as SPEED_MM_S,
    WIDTH_MM as WIDTH_MM,
    photo_to_touch as photo_to_touch,
)
from .sound_card import (
    opened_card as opened_card,
)
from .streaming.backends import (
    Clock as Clock,
)
from .streaming.contact import (
    ContactSettings as ContactSettings,
)
from .streaming.engine import (
    LONGEST_BLOCK_S as LONGEST_BLOCK_S,
    Engine as Engine,
)
from .streaming.motion import (
    MotionSample as MotionSample,
    MotionSettings as MotionSettings,
)
from .streaming.noise_texture import (
    NoiseTable as NoiseTable,
)
from .streaming.output import (
    DisplayOutput as DisplayOutput,
    Stream as Stream,
    check_streams as check_streams,
)
from .streaming.recorded_motion import (
    MICE as MICE,
    MotionFile as MotionFile,
    MouseMotion as MouseMotion,
    SimulatedHand as SimulatedHand,
)
from .streaming.texture_table import (
    TextureTable as TextureTable,
)
from .streaming.textures import (
    Along as Along,
    StreamingTexture as StreamingTexture,
    SurfaceTexture as SurfaceTexture,
    looped as looped,
)
from .transducer.digilent import (
    find_devices as find_devices,
)
