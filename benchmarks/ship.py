"""Put a run of texture_flow's foundation into the package: ``python -m benchmarks.ship RUN STORE``.

Instead of its own materials it knows those of a store, e.g. of ``tactogram data simulate everyday``.
"""

import json
import sys
from dataclasses import asdict, replace
from pathlib import Path

from tactogram.datasets import open_store
from tactogram.model import Example
from tactogram.models import SHIPPED, find
from tactogram.models.texture_flow.tonal_surfaces import split_strokes
from tactogram.signal.io.atomic import write_text
from tactogram.training.checkpoint import save_state
from tactogram.workflows.training.loaded_run import load_run


def ship(folder, store):
    """Write the run to its model's folder, and return where."""
    loaded, known = load_run(folder), open_store(store)
    examples = [
        Example(
            info.id,
            loaded.prepare_vibration(
                known.signal(info.id, loaded.recipe.prepare.stream_of(known.streams_of(info.id)))
            ),
            info.material,
            condition={name: getattr(info, name) for name in ("speed_mm_s", "force_n", "contactor")},
        )
        for info in known.index
    ]
    out = find(loaded.facts.name).folder / SHIPPED
    out.mkdir(exist_ok=True)
    state = state_with_materials(loaded.model, examples)
    save_state(out / "model.safetensors", state)
    write_text(out / "recipe.toml", (loaded.run.folder / "recipe.toml").read_text(encoding="utf-8"))
    data = {name: value for name, value in loaded.run.data.items() if name not in ("path", "photographs")}
    data["materials"] = {"name": known.name, "licence": known.licence, "sha256": known.sha256}
    kind = asdict(replace(loaded.kind, materials=tuple(state["materials"])))
    for name, values in (
        ("data.json", data),
        ("model.json", {**loaded.run.facts(), "kind": kind}),
        ("environment.json", loaded.run.read_json("environment.json")),
    ):
        write_text(out / name, json.dumps(values, indent=1) + "\n")
    return out


def state_with_materials(learner, examples):
    """Return the state of a model that knows the materials of other recordings instead, as it is shipped."""
    names = ("seconds", "rms", "lowest", "codes", "conditions", "average", "teacher", "predictor")
    materials = tuple(dict.fromkeys(str(example.material) for example in examples))
    split = [split_strokes([e for e in examples if e.material == name]) for name in materials]
    noise = [example for _, rest in split for example in rest]
    others = {"surfaces": [], "materials": list(materials)}
    others |= {"strokes": learner.strokes_of(noise, materials)._asdict()}
    others |= {"tones": [[tones.state() for tones in patterns] for patterns, _ in split]}
    others |= {"local": [learner.known.local_of([e.signal for e in rest]) for _, rest in split]}
    return {name: value for name, value in learner.state().items() if name in names} | others


if __name__ == "__main__":
    print(ship(Path(sys.argv[1]), Path(sys.argv[2])))
