"""Neshov et al. 2026, Table 4, Figures 3 and 4: the proposed model, three others and its ablations.

Every method has the same pairs, split and number of steps. Seeds are paired, and each method is compared with the
proposed one by a two-sided paired t-test, as in Sec. 4.3. p is uncorrected: one of seven
comparisons below 0.05 means little.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.cli.printing import columns
from tactogram.nn import VGG19
from tactogram.workflows import ProgressCallback, compare_pictures
from tactogram_benchmark.experiments.artifacts import listed
from tactogram_benchmark.experiments.picture_cells import (
    about_cells,
    cell_texts,
    compared,
    data_of,
    facts_of_cells,
    run_of,
    table_cells,
    table_settings,
)

PROPOSED = "proposed"
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "pix2pix": ("pix2pix", {}),
    "pix2pixHD": ("pix2pixhd", {}),
    "Residue-Fusion GAN": ("residue_fusion_gan", {}),
    "without CBN": ("visual_tactile_gan", {"config.conditional": False}),
    "without L1": ("visual_tactile_gan", {"config.l1": 0.0}),
    "without FM": ("visual_tactile_gan", {"config.feature_matching": 0.0}),
    "one discriminator": ("visual_tactile_gan", {"config.discriminators": 1}),
    PROPOSED: ("visual_tactile_gan", {}),
}
"""Model, and changes of its recipe."""
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    "L1 weight 5": ("visual_tactile_gan", {"config.l1": 5.0}),
    "L1 weight 20": ("visual_tactile_gan", {"config.l1": 20.0}),
    "FM weight 20": ("visual_tactile_gan", {"config.feature_matching": 20.0}),
    "FM weight 80": ("visual_tactile_gan", {"config.feature_matching": 80.0}),
    "label probabilities": ("visual_tactile_gan", {"config.label": "probabilities"}),
}
"""Ours: half and twice each loss weight (10 and 40; Sec. 3.1 leaves their sensitivity open), and conditioning on the
instance (future work in Sec. 4.5), by the predicted probabilities of all labels."""
PUBLISHED = {
    "pix2pix": ((0.3513, 0.0089), (52.23, 2.01)),
    "pix2pixHD": ((0.3345, 0.0105), (43.60, 1.88)),
    "Residue-Fusion GAN": ((0.3198, 0.0075), (40.76, 1.83)),
    "without CBN": ((0.3439, 0.0093), (45.42, 2.10)),
    "without L1": ((0.3278, 0.0087), (41.67, 2.14)),
    "without FM": ((0.3247, 0.0068), (41.29, 1.98)),
    "one discriminator": ((0.3458, 0.0080), (47.60, 1.91)),
    PROPOSED: ((0.3113, 0.0087), (38.77, 1.92)),
}
"""LPIPS and FID, mean and sd of 10 runs: nine materials of LMT-108, acceleration."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    trainings: int = 3,
    methods: str = "",
    protocol: str = "",
    alexnet: str = "",
    inception: str = "",
    vgg19: str = "",
    densenet201: str = "",
) -> dict[str, Any]:
    """Return every method's figures and their comparison with the proposed model's.

    Parameters
    ----------
    data : str
        Store with photographs; default: simulated surfaces.
    trainings : int
        Seeds per method; 10 in the paper.
    methods : str
        Beside the proposed model only these, such as ``pix2pix,without CBN``, or ``variants`` (`VARIANTS`: other loss
        weights, and label probabilities as condition); default: the published ones.
    protocol : str
        Order of splitting, cutting and pairing: ``crop-split`` (the paper's, of ``paper``), ``source-split`` (ours) or
        ``pair-then-split``.
    alexnet, inception, vgg19, densenet201 : str
        Files of published weights (`tactogram doctor` lists them); default: torch's cache.
    """
    chosen = _wanted(methods)
    files = {"alexnet": alexnet, "inception": inception, "vgg19": vgg19, "densenet201": densenet201}
    settings = table_settings(paper=paper, protocol=protocol, progress=progress, **files)
    store = data_of(folder, data, paper=paper, progress=progress)
    cells = table_cells(folder, store, chosen, settings=settings, trainings=trainings, progress=progress)
    rows = {
        name: {
            **row,
            "published_lpips": PUBLISHED[name][0] if name in PUBLISHED else None,
            "published_fid": PUBLISHED[name][1] if name in PUBLISHED else None,
        }
        for name, row in compared(cells, PROPOSED).items()
    }
    runs = {name: run_of(folder, settings.run_name(name, model), 0) for name, (model, _) in chosen.items()}
    figure = folder / "figure3.png"
    if all((run_folder / "model.json").is_file() for run_folder in runs.values()):
        attention = [name for name in (PROPOSED, "without CBN") if name in chosen]
        compare_pictures(runs, figure, attention=attention, progress=progress)
    facts = facts_of_cells(store, settings, cells)
    if VGG19.network in settings.missing:
        facts["missing"] = facts["missing"] | {"perceptual loss": settings.missing[VGG19.network]}
    result = {
        "figure": str(figure) if figure.is_file() else None,
        "table": 4,
        **facts,
        "best": {
            measure: min(rows, key=lambda name: rows[name]["test"][measure]["mean"])
            for measure in rows[PROPOSED]["test"]
        },
        "methods": rows,
    }
    return result | {"text": _text(result)}


def _wanted(names: str) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return model and changes of the named methods, of the published ones for none; always of the proposed."""
    known = METHODS | VARIANTS
    named = listed(names, (*known, "variants"), "methods") or list(METHODS)
    wanted = [method for name in named for method in (VARIANTS if name == "variants" else (name,))]
    return {name: known[name] for name in known if name in {*wanted, PROPOSED}}


def _text(result: dict[str, Any]) -> str:
    rows = result["methods"]
    table = [("", "published LPIPS", "published FID", *rows[PROPOSED]["test"])]
    for name, row in rows.items():
        lpips, fid = row["published_lpips"], row["published_fid"]
        published = "–" if lpips is None else f"{lpips[0]:.4f} ± {lpips[1]:.4f}"
        published_fid = "–" if fid is None else f"{fid[0]:.2f} ± {fid[1]:.2f}"
        table.append((name, published, published_fid, *cell_texts(row, digits=3)))
    lines = [
        f"Table 4 on {about_cells(result, PROPOSED)}; published: real accelerations of LMT-108, 10 trainings",
        columns(table),
    ]
    return "\n".join([*lines, *(f"{name}: {why}" for name, why in result["missing"].items())])
