from .autoregressive import (
    AutoregressiveModel as AutoregressiveModel,
    symmetric_root as symmetric_root,
)
from .autoregressive_fit import (
    fit_autoregressive as fit_autoregressive,
    reflection_of_autocorrelation as reflection_of_autocorrelation,
)
from .crest_factor import (
    periodic_signal as periodic_signal,
    random_phases as random_phases,
)
from .displacement import (
    over_displacement as over_displacement,
    played as played,
)
from .figure import (
    AXIS_COLOURS as AXIS_COLOURS,
    signal_figure as signal_figure,
)
from .filters import (
    dft321 as dft321,
)
from .joining import (
    join as join,
)
from .line_spectrum import (
    polynomial_of_reflection as polynomial_of_reflection,
    reflection_of_line_spectrum as reflection_of_line_spectrum,
    reflection_of_polynomial as reflection_of_polynomial,
)
from .listening import (
    audible as audible,
    strongest_axis as strongest_axis,
)
from .modulated_noise import (
    SCORES as SCORES,
    ModulatedNoise as ModulatedNoise,
    level_factor as level_factor,
)
from .modulated_noise_synthesis import (
    NoiseProcess as NoiseProcess,
    band_sections as band_sections,
    parameter_views as parameter_views,
    parameters_of as parameters_of,
    synthesise_modulated_noise as synthesise_modulated_noise,
)
from .perception import (
    FELT_HZ as FELT_HZ,
    detection_threshold as detection_threshold,
    sensation_level_db as sensation_level_db,
    weighted as weighted,
)
from .resampling import (
    check_growth as check_growth,
    resample as resample,
)
from .signal import (
    UNITS as UNITS,
    Domain as Domain,
    Image as Image,
    Signal as Signal,
    check_rate as check_rate,
    signal_of as signal_of,
)
from .synthesis import (
    ladder as ladder,
    synthesise as synthesise,
)
from .texture_map import (
    ModelMap as ModelMap,
    NoiseMap as NoiseMap,
    TextureMap as TextureMap,
)
from .timing import (
    estimate_timing as estimate_timing,
    to_uniform as to_uniform,
)
from .units import (
    STANDARD_GRAVITY as STANDARD_GRAVITY,
    TIME_UNITS as TIME_UNITS,
    parse_seconds as parse_seconds,
    parse_unit as parse_unit,
    split_heading as split_heading,
)
