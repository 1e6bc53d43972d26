"""``python -m tactogram`` is ``tactogram``."""

import sys

from tactogram.cli.command import main

sys.exit(main())
