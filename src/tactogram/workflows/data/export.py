"""Stores as data sets of the Hugging Face Hub: Parquet files of one schema, and a card that names them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from tactogram.datasets import Store
from tactogram.datasets.store.layout import StoredFile, open_parquet, schema
from tactogram.datasets.store.pending import new_folder
from tactogram.datasets.store.remote import arrow_place
from tactogram.signal.io.archives import decoding
from tactogram.signal.io.atomic import write_text

LICENCES = re.compile(r"(cc0|cc-by[a-z-]*|mit|apache|odc-by|odbl|bsd[a-z0-9-]*)(-[0-9.]+)?")
"""Names of licences that the Hub knows, in lower case; others are ``other``."""
PHOTOGRAPH_FEATURES = {
    "key": {"dtype": "string", "_type": "Value"},
    "mm_per_pixel": {"dtype": "float64", "_type": "Value"},
    "image": {"_type": "Image"},
    "materials": {"feature": {"dtype": "string", "_type": "Value"}, "_type": "List"},
}
"""Columns of the photographs as the Hub's reader declares them: only so does it decode the pictures."""


def write_hub_dataset(store: Store, out: Path) -> None:
    """Write a store into a new folder; `RunError` if it exists."""
    configs = [("default", "data/*.parquet")]
    with new_folder(out) as folder, decoding(str(store.folder), "damaged", remedy="import the data again"):
        _write_recordings(store, folder / "data")
        if store.facts.images:
            configs.append(("photographs", "photographs/*.parquet"))
            _write_photographs(store, folder / "photographs")
        if store.facts.ratings is not None:
            configs.append(("ratings", "ratings/*.parquet"))
            ds.write_dataset(_dataset(store, store.facts.ratings), folder / "ratings", format="parquet")
        write_text(folder / "README.md", _card(store, configs))


def _dataset(store: Store, *files: StoredFile, schema: pa.Schema = None) -> ds.Dataset:
    """Return files of a store; columns of ``schema`` that a file lacks are null."""
    for stored in files:
        open_parquet(store.folder / stored.file, stored)
    system, folder = arrow_place(store.folder)
    return ds.dataset([f"{folder}/{stored.file}" for stored in files], schema=schema, filesystem=system)


def _write_recordings(store: Store, folder: Path) -> None:
    """Write a row per recording; maps, which the Hub's reader lacks, become lists of key and value."""
    columns = {}
    for field in schema(store.streams):
        column = ds.field(field.name)
        if pa.types.is_map(field.type):
            pair = pa.struct([("key", field.type.key_type), ("value", field.type.item_type)])
            column = column.cast(pa.list_(pair))
        columns["photograph" if field.name == "image" else field.name] = column
    shards = _dataset(store, *store.facts.shards, schema=schema(store.streams))
    ds.write_dataset(shards.scanner(columns=columns), folder, format="parquet", preserve_order=True)


def _write_photographs(store: Store, folder: Path) -> None:
    """Write every photograph with its materials as a picture that the Hub's reader decodes."""
    materials: dict[str, list[str]] = {}
    for material, keys in store.photographs_by_material.items():
        for key in keys:
            materials.setdefault(key, []).append(material)
    info = json.dumps({"info": {"features": PHOTOGRAPH_FEATURES}})
    folder.mkdir()
    for number, stored in enumerate(store.facts.images):
        table = _dataset(store, stored).to_table(columns=["key", "mm_per_pixel", "image"])
        path = pa.nulls(len(table), pa.string())
        pictures = pc.make_struct(table["image"].combine_chunks(), path, field_names=["bytes", "path"])
        shown = [materials.get(key, []) for key in table["key"].to_pylist()]
        table = table.set_column(2, "image", pictures)
        table = table.append_column("materials", pa.array(shown, pa.list_(pa.string())))
        pq.write_table(
            table.replace_schema_metadata({"huggingface": info}), folder / f"part-{number}.parquet"
        )


def _card(store: Store, configs: list[tuple[str, str]]) -> str:
    from huggingface_hub import DatasetCardData

    known = LICENCES.fullmatch(store.licence.lower()) is not None
    head = DatasetCardData(
        license=store.licence.lower() if known else "other",
        license_name=None if known else store.licence,
        pretty_name=store.name,
        tags=["haptics", "tactile", *(["simulated-data"] if store.simulated else [])],
        configs=[
            {"config_name": name, "data_files": [{"split": "train", "path": path}]} for name, path in configs
        ],
    )
    simulated = " All or some of it was simulated." if store.simulated else ""
    streams = "\n".join(
        f"| {name} | {facts.unit} | {facts.domain} | {', '.join(facts.axes)} |"
        for name, facts in store.streams.items()
    )
    return f"""---
{head.to_yaml()}
---

# {store.name}

{len(store)} recordings of touch, written by tactogram.{simulated} Licence, as the source states it: {store.licence}.
SHA-256 of the content: `{store.sha256}`.

| stream | unit | over | axes |
| --- | --- | --- | --- |
{streams}

A row is a recording. Each stream `NAME` has `NAME_rate` (Hz, or samples per mm over displacement), `NAME_axes`,
`NAME_length` (samples per axis) and a list of samples per axis, `NAME_AXIS`, null where a recording lacks it.
`photograph` is a key in the configuration `photographs`. There is one split: how to divide recordings without leaks
depends on the question.
"""
