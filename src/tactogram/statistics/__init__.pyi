from .comparison import (
    INDEPENDENT as INDEPENDENT,
    Comparison as Comparison,
    friedman_wilcoxon as friedman_wilcoxon,
    mann_whitney as mann_whitney,
    paired_equivalence as paired_equivalence,
    pseudomedian as pseudomedian,
    signed_rank_p as signed_rank_p,
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
    GroupSummary as GroupSummary,
    holm as holm,
    holm_rows as holm_rows,
    nan_mean as nan_mean,
    pooled as pooled,
    summary as summary,
)
from .reliability import (
    krippendorff_alpha as krippendorff_alpha,
)
