"""Stores in the layout of the Hub's data sets: Parquet shards of one schema, and a card that names them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets import Store
from tactogram.datasets.store.layout import schema
from tactogram.datasets.store.parquet import open_parquet
from tactogram.datasets.store.photographs import COLUMNS as PHOTOGRAPH_COLUMNS
from tactogram.datasets.store.remote import RemotePath
from tactogram.signal.io.atomic import write_text

PAIRS = {"ratings": ("word", "score"), "labels": ("name", "value")}
"""Columns that are maps in a store, which the Hub's reader lacks: names of key and value in a list of structs."""
PICTURE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
"""How the Hub's reader stores a picture."""
LICENCES = re.compile(r"(cc0|cc-by[a-z-]*|mit|apache|odc-by|odbl|bsd[a-z0-9-]*)(-[0-9.]+)?")
"""Names of licences that the Hub knows, in lower case; others are ``other``."""
SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (1_000_000, "100K<n<1M"))


def write_hub_dataset(store: Store, folder: Path) -> dict[str, Any]:
    """Write recordings, photographs and ratings of a store into ``folder``; return the number of each."""
    configs = [("default", "data/train-*.parquet")]
    (folder / "data").mkdir()
    wanted = _schema(store)
    count = len(store.facts.shards)
    for number, stored in enumerate(store.facts.shards):
        file = folder / "data" / f"train-{number:05d}-of-{count:05d}.parquet"
        with open_parquet(store.folder / stored.file, stored) as shard, pq.ParquetWriter(file, wanted) as out:
            for group in range(shard.num_row_groups):
                out.write_table(_unified(shard.read_row_group(group), wanted))
    photographs = 0
    if store.facts.images:
        (folder / "photographs").mkdir()
        configs.append(("photographs", "photographs/*.parquet"))
        photographs = _write_photographs(store, folder / "photographs" / "train.parquet")
    if store.facts.ratings is not None:
        (folder / "ratings").mkdir()
        configs.append(("ratings", "ratings/*.parquet"))
        ratings = store.folder / store.facts.ratings.file
        table = pq.read_table(ratings.open() if isinstance(ratings, RemotePath) else ratings)
        pq.write_table(table, folder / "ratings" / "train.parquet")
    write_text(folder / "README.md", _card(store, configs))
    return {"recordings": len(store), "photographs": photographs, "shards": count}


def card_head(store: Store, **more: Any) -> str:
    """Return the YAML of a data set's card."""
    from huggingface_hub import DatasetCardData

    licence = store.licence.lower()
    known = LICENCES.fullmatch(licence) is not None
    size = next((name for most, name in SIZES if len(store) < most), "n>1M")
    tags = ["haptics", "tactile", *more.pop("tags", ()), *(["simulated-data"] if store.simulated else [])]
    head = DatasetCardData(
        license=licence if known else "other",
        license_name=None if known else store.licence,
        pretty_name=store.name,
        size_categories=[size],
        tags=tags,
        **more,
    )
    return f"---\n{head.to_yaml()}\n---\n"


def streams_table(store: Store) -> str:
    """Return the streams of a store as a table in Markdown."""
    rows = [
        f"| {name} | {facts.unit} | {facts.domain} | {', '.join(facts.axes)} |"
        for name, facts in store.streams.items()
    ]
    return "\n".join(("| stream | unit | over | axes |", "| --- | --- | --- | --- |", *rows))


def origin(store: Store) -> str:
    """Return where the data are from, in one paragraph."""
    simulated = " All or some of it was simulated." if store.simulated else ""
    return (
        f"{len(store)} recordings of touch, written by tactogram.{simulated} Licence, as the source states it: "
        f"{store.licence}. SHA-256 of the content: `{store.sha256}`."
    )


def _schema(store: Store) -> pa.Schema:
    """Return the columns of every shard: those of all streams, with lists of structs in place of maps."""
    fields = []
    for field in schema(store.streams):
        if field.name in PAIRS:
            key, value = PAIRS[field.name]
            kind = pa.list_(pa.struct([(key, field.type.key_type), (value, field.type.item_type)]))
            fields.append(pa.field(field.name, kind))
        else:
            fields.append(pa.field("photograph" if field.name == "image" else field.name, field.type))
    return pa.schema(fields)


def _unified(table: pa.Table, wanted: pa.Schema) -> pa.Table:
    table = table.rename_columns(["photograph" if name == "image" else name for name in table.column_names])
    columns = []
    for field in wanted:
        if field.name not in table.column_names:
            columns.append(pa.nulls(len(table), field.type))
        elif field.name in PAIRS:
            maps = table[field.name].combine_chunks()
            entries = pa.StructArray.from_arrays([maps.keys, maps.items], names=list(PAIRS[field.name]))
            columns.append(pa.ListArray.from_arrays(maps.offsets, entries).cast(field.type))
        else:
            columns.append(table[field.name])
    return pa.table(columns, schema=wanted)


def _write_photographs(store: Store, file: Path) -> int:
    """Write every photograph with its materials as a picture that the Hub's reader decodes."""
    materials: dict[str, list[str]] = {}
    for material, keys in store.photographs_by_material.items():
        for key in keys:
            materials.setdefault(key, []).append(material)
    kinds = {"key": "string", "mm_per_pixel": "float64"}
    features: Mapping[str, Any] = {
        **{name: {"dtype": kind, "_type": "Value"} for name, kind in kinds.items()},
        "materials": {"feature": {"dtype": "string", "_type": "Value"}, "_type": "List"},
        "image": {"_type": "Image"},
    }
    columns = {
        "key": pa.string(),
        "mm_per_pixel": pa.float64(),
        "materials": pa.list_(pa.string()),
        "image": PICTURE,
    }
    wanted = pa.schema(columns, metadata={"huggingface": json.dumps({"info": {"features": features}})})
    count = 0
    with pq.ParquetWriter(file, wanted) as out:
        for row in _photographs(store):
            picture = {"bytes": row["image"], "path": None}
            out.write_table(
                pa.Table.from_pylist(
                    [row | {"image": picture, "materials": materials.get(row["key"], [])}], wanted
                )
            )
            count += 1
    return count


def _photographs(store: Store) -> Iterator[dict[str, Any]]:
    for stored in store.facts.images:
        with open_parquet(store.folder / stored.file, stored) as file:
            for group in range(file.num_row_groups):
                yield from file.read_row_group(group, columns=PHOTOGRAPH_COLUMNS.names).to_pylist()


def _card(store: Store, configs: list[tuple[str, str]]) -> str:
    head = card_head(
        store,
        configs=[
            {"config_name": name, "data_files": [{"split": "train", "path": path}]} for name, path in configs
        ],
    )
    return f"""{head}
# {store.name}

{origin(store)}

## Streams

{streams_table(store)}

A row is a recording. Each stream `NAME` has `NAME_rate` (Hz, or samples per mm over displacement), `NAME_axes`,
`NAME_length` (samples per axis) and a list of samples per axis, `NAME_AXIS`, null where a recording lacks it.
`photograph` is a key in the configuration `photographs`. There is one split: how to divide recordings without leaks
depends on the question.
"""
