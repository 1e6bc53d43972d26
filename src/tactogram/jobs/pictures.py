"""Judge the pictures that a run makes of photographs: distances of pictures, and of the signals inverted from them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.datasets import Examples
from tactogram.errors import ParameterError
from tactogram.evaluation.attention_maps import attention_maps
from tactogram.evaluation.picture_figures import PictureCase, failures_figure, pictures_figure
from tactogram.evaluation.picture_inversion import Loss, inversion_loss, mean_loss
from tactogram.evaluation.pictures import MEASURES, PictureJudge, PictureWeights
from tactogram.evaluation.report import Picture, Section, Table
from tactogram.jobs.progress import Progress, silent
from tactogram.jobs.training import LoadedRun, load_run, part_examples, test_part
from tactogram.training.seeds import torch_seeded

MOST_PAIRS = 256
"""Pairs of the test part that are judged, evenly spread over it."""
MOST_INVERTED = 12
"""Pictures of each material whose signals are judged."""
MOST_SHOWN = 9
"""Materials in the figure: as many as the paper's Figure 3 has."""
BATCH = 32


def makes_pictures(loaded: LoadedRun) -> bool:
    """Whether a run turns photographs into spectrogram pictures."""
    return hasattr(loaded.model, "ends") and hasattr(loaded.model, "make")


def judge_pictures(
    run: Path | str | LoadedRun,
    *,
    weights: PictureWeights | None = None,
    most: int = MOST_PAIRS,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Return how far the pictures of ``run`` are from those of recordings that it was not trained on.

    Parameters
    ----------
    run : path or LoadedRun
        Of a model that turns photographs into spectrogram pictures.
    weights : PictureWeights, optional
        Where the networks of LPIPS and FID are; by default in torch's cache.
    most : int
        Pairs that are judged.

    Returns
    -------
    dict
        What `PictureJudgement.as_dict` gives; ``per_material`` the log-spectral distance of each; ``label_accuracy``
        where the model names surfaces; ``inversion``, whose the loss of the inverted signals is (`Loss`, with
        ``network`` and ``share_of_inversion``); ``split`` and ``simulated``.

    Raises
    ------
    ParameterError
        If the model makes no pictures, or no photograph or recording of the test part is large enough.
    """
    return judged_pictures(run, weights=weights, most=most, progress=progress)[0]


def judged_pictures(
    run: Path | str | LoadedRun,
    *,
    weights: PictureWeights | None = None,
    most: int = MOST_PAIRS,
    progress: Progress = silent,
) -> tuple[dict[str, Any], list[Section]]:
    """Return the figures of `judge_pictures` and the sections of a report on them."""
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if not makes_pictures(loaded):
        raise ParameterError(f"{loaded.facts.name} makes no spectrogram pictures of photographs")
    picture = loaded.model.ends.picture
    train, test = _parts(loaded)
    pairs = _pairs(loaded, test, most, progress)
    found = PictureJudge(picture, weights=weights or PictureWeights())(pairs.real, pairs.made).as_dict()
    plain = PictureJudge(picture, networks=False)
    found["per_material"] = {
        name: plain(pairs.real[places], pairs.made[places]).values["log_spectral_distance_db"]
        for name, places in pairs.by_material().items()
        if len(places) > 1
    }
    if pairs.named_rightly is not None:
        found["label_accuracy"] = pairs.named_rightly
    losses = _inversion(loaded, pairs, train, test, progress)
    found["inversion"] = {
        name: asdict(loss) | {"network": loss.network, "share_of_inversion": loss.share_of_inversion}
        for name, loss in losses.items()
    }
    found |= {"split": loaded.run.data["split"], "simulated": loaded.kind.simulated}
    return found, _sections(loaded, found, pairs, losses)


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Photographs (pair, 1, row, column), the pictures of their pairs and those made of them, and the materials."""

    photo: Tensor
    real: Tensor
    made: Tensor
    materials: tuple[str, ...]
    named_rightly: float | None

    def by_material(self) -> dict[str, NDArray[np.intp]]:
        return {
            name: np.flatnonzero(np.equal(self.materials, name).astype(bool))
            for name in sorted(set(self.materials))
        }


def _parts(loaded: LoadedRun) -> tuple[Examples, Examples]:
    """Return training and test part; the same twice where the protocol splits crops instead."""
    store, split = test_part(loaded.run)
    train, test = (
        part_examples(store, split, part, loaded.as_trained, label=loaded.run.data["label"])
        for part in ("train", "train" if loaded.model.ends.splits_crops else "test")
    )
    return train, test


def _pairs(loaded: LoadedRun, test: Examples, most: int, progress: Progress) -> _Pairs:
    model = loaded.model
    pairs = model.ends.pairs(test, "test") if model.ends.splits_crops else model.ends.unseen(test)
    if pairs is None:
        raise ParameterError(
            f"{loaded.run.name}: the test part has no photograph and recording that are large enough to be judged by"
        )
    places = np.unique(np.linspace(0, len(pairs) - 1, min(len(pairs), most)).round().astype(int))
    batches, made, named = [], [], []
    with torch_seeded(loaded.recipe.seed, "judge pictures"):  # pix2pix draws its dropout in use
        for begin in range(0, len(places), BATCH):
            batch = pairs.batch(places[begin : begin + BATCH])
            batches.append(batch)
            made.append(model.make(batch.photo).float().cpu())
            if getattr(model, "predictor", None) is not None:
                named.append(model.predictor.probabilities(batch.photo).argmax(1).cpu() == batch.label)
            progress("make pictures", begin + len(batch), len(places))
    sources = [pairs.photo_sources[crop // pairs.crops.per_photo] for crop in pairs.pairs[places, 0]]
    return _Pairs(
        torch.cat([batch.photo for batch in batches]),
        torch.cat([batch.picture for batch in batches]),
        torch.cat(made),
        tuple(source.material for source in sources),
        float(torch.cat(named).float().mean()) if named else None,
    )


def _inversion(
    loaded: LoadedRun, pairs: _Pairs, train: Examples, test: Examples, progress: Progress
) -> dict[str, Loss]:
    """Return the loss of the inverted signals, the mean over materials."""
    picture, places = loaded.model.ends.picture, pairs.by_material()
    held: dict[str, list[list[Any]]] = {name: [[], []] for name in places}
    for side, part in enumerate((test, train)):
        for example in part:
            if example.material in held and len(example.signal) >= picture.length:
                held[example.material][side].append(example.signal)
    losses = []
    for done, (name, (real, others)) in enumerate(held.items(), 1):
        if real:
            made = pairs.made[places[name][:MOST_INVERTED]]
            losses.append(inversion_loss(real, made, picture, others=others, seed=loaded.recipe.seed))
        progress("invert pictures", done, len(held))
    return mean_loss(losses) if losses else {}


# -- the report -----------------------------------------------------------------------------------------------


def _sections(
    loaded: LoadedRun, found: dict[str, Any], pairs: _Pairs, losses: dict[str, Loss]
) -> list[Section]:
    rows = [
        (MEASURES[name][0] if name in MEASURES else name, value, MEASURES.get(name, ("", "–"))[1])
        for name, value in found["values"].items()
    ]
    caption = f"{found['pictures']} pairs of the test part. {found['protocol']}."
    missing = "".join(f" {name} is missing: {why}." for name, why in found["missing"].items())
    blocks: list[Any] = [Table(("measure", "value", "better"), rows, caption + missing)]
    cases = _cases(loaded, pairs)
    picture = loaded.model.ends.picture
    first = [places[0] for places in pairs.by_material().values()][:MOST_SHOWN]
    blocks.append(
        Picture(
            pictures_figure([cases(place, attention=True) for place in first], picture),
            "A crop of a photograph of the test part, the picture of a recording of the same material (a weak pair: it "
            "is not of the same place), the picture made, and where the last layer was active (Grad-CAM).",
        )
    )
    errors = (pairs.real - pairs.made).abs().mean(dim=(1, 2, 3)).tolist()
    blocks.append(
        Picture(
            failures_figure(
                [cases(place) for place in range(len(errors))], errors, picture, measure="mean absolute error"
            ),
            "The worst, by measured error, one per material.",
        )
    )
    sections = [Section("Pictures", blocks)]
    if losses:
        lost = [(name, loss.floor, loss.inversion, loss.total, loss.network) for name, loss in losses.items()]
        table = Table(
            (
                "measure",
                "other recordings",
                "pictured and inverted",
                "made and inverted",
                "the network's part",
            ),
            lost,
            "Mean over materials, lower is better. Whose the loss is: recordings made to pictures and back pay for "
            "phase and resizing alone; what generated pictures add is the network's.",
        )
        sections.append(Section("From pictures back to vibration", [table]))
    return sections


def _cases(loaded: LoadedRun, pairs: _Pairs) -> Any:
    model = loaded.model
    given = getattr(model, "given", lambda photo: ())

    def case(place: int, *, attention: bool = False) -> PictureCase:
        pictures = {"recorded": pairs.real[place], "made": pairs.made[place]}
        maps = None
        if attention:
            photo = pairs.photo[place : place + 1]
            maps = {"made": attention_maps(model.gan.bare_generator.eval(), photo, *given(photo))[0]}
        return PictureCase(pairs.materials[place], pairs.photo[place], pictures, maps)

    return case
