from .friction_fit import (
    FrictionMeasurements as FrictionMeasurements,
    calibrated as calibrated,
    read_pairs as read_pairs,
    write_calibrations as write_calibrations,
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
from .streaming.mouse import (
    MICE as MICE,
    MouseMotion as MouseMotion,
)
from .streaming.noise_texture import (
    NoiseTable as NoiseTable,
)
from .streaming.output import (
    DisplayOutput as DisplayOutput,
    Stream as Stream,
    check_streams as check_streams,
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
from .workflows.actuators import (
    play as play,
)
from .workflows.carrier_tracking import (
    CarrierTracking as CarrierTracking,
)
from .workflows.playback import (
    CAREFUL as CAREFUL,
    NULL as NULL,
    Playback as Playback,
    full_scale_of as full_scale_of,
    outputs as outputs,
)
from .workflows.session import (
    Backend as Backend,
    rehearsal as rehearsal,
    run as run,
)
from .workflows.stream import (
    stream as stream,
)
from .workflows.textures import (
    TextureSettings as TextureSettings,
    live_texture as live_texture,
    surface_of as surface_of,
    texture_of_map as texture_of_map,
)
