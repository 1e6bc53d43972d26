from .cells import (
    cell_text as cell_text,
    check_parquet as check_parquet,
    finite_number as finite_number,
    number_columns as number_columns,
    read_cells as read_cells,
)
from .examples import (
    Examples as Examples,
    cores as cores,
    part_examples as part_examples,
    require_photographs as require_photographs,
    signal_kind as signal_kind,
)
from .importer import (
    ImportedPhotograph as ImportedPhotograph,
    ImportItem as ImportItem,
    check_positive as check_positive,
    files_below as files_below,
)
from .importers.folder import (
    MATERIAL_FROM as MATERIAL_FROM,
)
from .mapping import (
    TableMapping as TableMapping,
    layouts_by_columns as layouts_by_columns,
    read_mapping as read_mapping,
    write_mapping as write_mapping,
)
from .preview import (
    preview_dataset as preview_dataset,
    preview_file as preview_file,
    proposed_layouts as proposed_layouts,
)
from .ratings.questionnaires import (
    Export as Export,
    export_of as export_of,
    rows_left_out as rows_left_out,
)
from .ratings.questions import (
    MISSING as MISSING,
    Questions as Questions,
    RatingColumns as RatingColumns,
)
from .ratings.ratings import (
    EVOKED as EVOKED,
    SEVEN_POINT as SEVEN_POINT,
    Ratings as Ratings,
    Scale as Scale,
    join_ratings as join_ratings,
    scale_of as scale_of,
)
from .ratings.table import (
    read_table as read_table,
    write_table as write_table,
)
from .ratings.words import (
    JAPANESE as JAPANESE,
    WORDS as WORDS,
)
from .reading import (
    in_one_line as in_one_line,
)
from .recording import (
    Label as Label,
    Recording as Recording,
    RecordingInfo as RecordingInfo,
    item_of as item_of,
    label_of as label_of,
)
from .splits.photograph_splitting import (
    PhotographRegions as PhotographRegions,
    materials_without_photographs as materials_without_photographs,
    materials_without_recordings as materials_without_recordings,
    split_photographs as split_photographs,
    whole_photographs as whole_photographs,
)
from .splits.split import (
    By as By,
    Region as Region,
    Segment as Segment,
    Split as Split,
)
from .splits.splitting import (
    contiguous_blocks as contiguous_blocks,
    kfold as kfold,
    split_fractions as split_fractions,
    split_last as split_last,
)
from .store.pending import (
    clear_stale_parts as clear_stale_parts,
    new_folder as new_folder,
)
from .store.photographs import (
    PICTURES as PICTURES,
)
from .store.store import (
    Store as Store,
    open_store as open_store,
)
from .store.writing import (
    add_ratings as add_ratings,
    add_recordings as add_recordings,
    append_recording as append_recording,
    check_new as check_new,
    create_store as create_store,
    new_store as new_store,
    recover_store as recover_store,
)
