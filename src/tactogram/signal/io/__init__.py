"""Reading and writing of signals, with unit and level, and of pictures."""

from tactogram.signal.io.files import READABLE as READABLE
from tactogram.signal.io.files import WRITABLE as WRITABLE
from tactogram.signal.io.files import SignalFile as SignalFile
from tactogram.signal.io.files import complete as complete
from tactogram.signal.io.files import read_columns as read_columns
from tactogram.signal.io.files import read_contents as read_contents
from tactogram.signal.io.files import read_file as read_file
from tactogram.signal.io.files import read_metadata as read_metadata
from tactogram.signal.io.files import read_signal as read_signal
from tactogram.signal.io.files import write_signal as write_signal
from tactogram.signal.io.picture import MOST_PIXELS as MOST_PIXELS
from tactogram.signal.io.picture import PICTURE_FORMATS as PICTURE_FORMATS
from tactogram.signal.io.picture import decode_image as decode_image
from tactogram.signal.io.picture import decode_image_metadata as decode_image_metadata
from tactogram.signal.io.picture import read_image as read_image
from tactogram.signal.io.picture import read_image_metadata as read_image_metadata
from tactogram.signal.io.picture import write_image as write_image
