"""Put a run of texture_flow's foundation into the package, without its materials: ``python -m benchmarks.ship RUN``."""

import json
import sys
from dataclasses import asdict, replace
from pathlib import Path

from tactogram.models import SHIPPED, find
from tactogram.signal.io.atomic import write_text
from tactogram.training.checkpoint import save_state
from tactogram.workflows.training.loaded_run import load_run


def ship(folder):
    """Write the run to its model's folder, and return where."""
    loaded = load_run(folder)
    out = find(loaded.facts.name).folder / SHIPPED
    out.mkdir(exist_ok=True)
    save_state(out / "model.safetensors", loaded.model.state_without_materials())
    write_text(out / "recipe.toml", (loaded.run.folder / "recipe.toml").read_text(encoding="utf-8"))
    data = {name: value for name, value in loaded.run.data.items() if name not in ("path", "photographs")}
    kind = asdict(replace(loaded.kind, materials=()))
    for name, values in (
        ("data.json", data),
        ("model.json", {**loaded.run.facts(), "kind": kind}),
        ("environment.json", loaded.run.read_json("environment.json")),
    ):
        write_text(out / name, json.dumps(values, indent=1) + "\n")
    return out


if __name__ == "__main__":
    print(ship(Path(sys.argv[1])))
