"""Options that name folders with further models, designs and the like."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

FOLDERS = {
    "models": "folder of further models",
    "designs": "a file or folder with further designs",
    "languages": "a file or folder with further language files",
    "tasks": "folder of further tasks",
    "stores": "a store, or a folder of stores",
}


def further_folders(given: Mapping[str, Sequence[str]]) -> None:
    """Let whatever loads a run or a session find its model or design by name in the folders that are given."""
    for option, folders in given.items():
        if folders:
            variable = f"TACTOGRAM_{option.upper()}"
            known = os.environ.get(variable)
            os.environ[variable] = os.pathsep.join([*folders, *([known] if known else [])])
