"""Upload to and download from the Hugging Face Hub, or a server with its interface (``HF_ENDPOINT``)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import RunError, TactogramError, one_line
from tactogram.extras import imported

Kind = Literal["model", "dataset"]
PREFIX = "hf://"
"""Before the name of a repository: ``hf://OWNER/NAME``, with ``@REVISION`` if it is not the newest."""


def hub_library() -> Any:
    """Return ``huggingface_hub``; `MissingExtraError` if it is not installed."""
    return imported("huggingface_hub", extra="hub", what="the layouts of the Hugging Face Hub")


def push(folder: Path, repository: str, *, kind: Kind) -> str:
    """Upload the files of ``folder`` to a repository, which is created if there is none; return its address.

    Raises `RunError` if the server refuses, or is not reached.
    """
    hub = hub_library()
    with _one_line(repository):
        api = hub.HfApi(endpoint=os.environ.get("HF_ENDPOINT"))
        api.create_repo(repository, repo_type=kind, exist_ok=True)
        done = api.upload_folder(
            repo_id=repository, folder_path=folder, repo_type=kind, commit_message="Upload by tactogram"
        )
    return str(done.commit_url)


def pull(address: str, folder: Path) -> None:
    """Download the model ``OWNER/NAME`` or ``OWNER/NAME@REVISION`` into ``folder``; errors as `push`."""
    hub = hub_library()
    repository, _, revision = address.partition("@")
    with _one_line(repository):
        hub.snapshot_download(
            repository, revision=revision or None, local_dir=folder, endpoint=os.environ.get("HF_ENDPOINT")
        )


@contextmanager
def _one_line(repository: str) -> Iterator[None]:
    """Turn every error of the library in the block into one line."""
    bars = hub_library().utils
    shown = not bars.are_progress_bars_disabled()
    bars.disable_progress_bars()
    try:
        yield
    except TactogramError:
        raise
    except Exception as error:
        hint = "; log in by `hf auth login`" if "401" in str(error) else ""
        raise RunError(f"{repository}: the Hub did not do it: {one_line(error)}{hint}") from error
    finally:
        if shown:
            bars.enable_progress_bars()
