from .clustered import (
    EffectEstimate as EffectEstimate,
    bootstrap_by_participant as bootstrap_by_participant,
    mixed_difference as mixed_difference,
    pooled_share as pooled_share,
)
from .comparison import (
    INDEPENDENT as INDEPENDENT,
    Comparison as Comparison,
    friedman_wilcoxon as friedman_wilcoxon,
    steel_dwass as steel_dwass,
    student_t as student_t,
)
from .figures import (
    BLUE as BLUE,
    GRAY as GRAY,
    INK as INK,
    ORANGE as ORANGE,
    error_figure as error_figure,
)
from .groups import (
    holm as holm,
    holm_rows as holm_rows,
    nan_mean as nan_mean,
    summary as summary,
)
from .paired import (
    paired_equivalence as paired_equivalence,
    pseudomedian as pseudomedian,
    signed_rank_p as signed_rank_p,
)
from .reliability import (
    krippendorff_alpha as krippendorff_alpha,
)
from .shares import (
    ShareEstimate as ShareEstimate,
    abx_share as abx_share,
    corrected as corrected,
    d_prime_2afc as d_prime_2afc,
    d_prime_abx as d_prime_abx,
    exact_ps as exact_ps,
    share_equivalence as share_equivalence,
    share_equivalence_power as share_equivalence_power,
    share_of as share_of,
    smallest_significant as smallest_significant,
)
