"""``python -m tactogram.cli`` is ``tactogram``."""

import sys

from tactogram.cli.command import main

sys.exit(main())
