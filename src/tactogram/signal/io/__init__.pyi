from .archives import (
    UndatedZip as UndatedZip,
    UnpackedSizeError as UnpackedSizeError,
    check_archive as check_archive,
)
from .arrays import (
    load_arrays as load_arrays,
)
from .atomic import (
    atomic_write as atomic_write,
    check_writable as check_writable,
    clear_parts as clear_parts,
    lock as lock,
    write_text as write_text,
)
from .content import (
    IGNORED as IGNORED,
    LABELS as LABELS,
    RATE as RATE,
    TIME as TIME,
    UNCLEAR as UNCLEAR,
    RawTable as RawTable,
    TableLayout as TableLayout,
    default_axes as default_axes,
)
from .files import (
    JSON_LINES as JSON_LINES,
    PACKED as PACKED,
    READABLE as READABLE,
    SOUND as SOUND,
    TEXTS as TEXTS,
    USUAL as USUAL,
    WRITABLE as WRITABLE,
    SignalFile as SignalFile,
    complete as complete,
    read_columns as read_columns,
    read_contents as read_contents,
    read_file as read_file,
    read_metadata as read_metadata,
    read_signal as read_signal,
    write_signal as write_signal,
)
from .hdf5 import (
    MAGIC as MAGIC,
)
from .matlab import (
    check_unpacked as check_unpacked,
)
from .picture import (
    decode_image as decode_image,
    decode_image_metadata as decode_image_metadata,
    picture_size as picture_size,
    read_image as read_image,
    read_image_metadata as read_image_metadata,
    write_image as write_image,
)
from .roles import (
    roles_of as roles_of,
)
from .sound import (
    read_header as read_header,
)
from .table import (
    text_table as text_table,
)
from .table_content import (
    column_numbers as column_numbers,
    unit_note as unit_note,
)
from .table_head import (
    TableHead as TableHead,
    head_of as head_of,
)
from .text_rows import (
    pairs_in as pairs_in,
    unstamped as unstamped,
)
from .vocabulary import (
    STREAM_OF_UNIT as STREAM_OF_UNIT,
    heading as heading,
    time_unit_of as time_unit_of,
)
