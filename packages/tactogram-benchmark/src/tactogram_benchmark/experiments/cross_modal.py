"""Hatori et al. 2025, Figures 5 and 6: errors of word ratings of touch with images against the plates' ratings.

Six conditions: the sensor's signal as the drive; generated signals alone; and generated signals shown with
images of the four weights, from the same scores. Simulated observers rate them: one group the first
two, as in the earlier study, another group the others. They weight touch and sight by reliability (Ernst & Banks
2002); the rules are in docs/simulated-raters.md and unknown to every model. ``ratings=FILE`` makes the
figures from real answers instead.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from tactogram.cli.printing import columns
from tactogram.datasets import Ratings, read_table
from tactogram.errors import ParameterError
from tactogram.evaluation import save_figure
from tactogram.signal import Image, Signal
from tactogram.workflows import ProgressCallback, generate_rated_surfaces, load_run
from tactogram_benchmark.experiments.artifacts import find_or_simulate, origin_of, trained_run, write_items
from tactogram_benchmark.experiments.cross_modal_errors import (
    ALPHA,
    CrossModalResult,
    compare_cross_modal,
    errors_of,
    overall_figure,
    per_word_figure,
)
from tactogram_benchmark.experiments.image_cells import WEIGHTS, draws_of, image_run, plates_of
from tactogram_simulate import draw_people, score_together, score_vibrations

PEOPLE = 20
"""In each of the two groups. Sec. II-D; n = 2,400 answers of 12 plates and 10 words in Fig. 5."""
WITHOUT_MODELS, WITHOUT_IMAGES = "without models", "without images"
SHOWN = 5000
"""Image weight in Fig. 6."""
PUBLISHED = {f"weight {SHOWN}": 1.6, WITHOUT_MODELS: 2.2}
"""Abstract: "reduced the mean absolute error … from 2.2 to 1.6"; we take 2.2 to be the first condition."""
PUBLISHED_BETTER = (1, 1000, 5000)
"""Weights with smaller errors than without images, p < 0.01. Sec. III-B."""
PUBLISHED_WORDS = (3, 8, ("rugged", "uneven"))
"""Number of words that improve without images, and with images; words that do not. Sec. III-B."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    images: str = "",
    data: str = "",
    signal_run: str = "",
    image_runs: str = "",
    ratings: str = "",
    recipe: str = "",
    seed: int = 0,
) -> dict[str, Any]:
    """Return the errors of the six conditions, overall and per word, and draw Figs. 5 and 6.

    Parameters
    ----------
    images, data : str
        Stores of rated images, and of rated plates and display signals; default: simulated.
    signal_run : str
        Run of ultrasonic_cgan on ``data``; default: group D is trained.
    image_runs : str
        Folder with ``weight-W-SEED`` for each weight, such as ``runs`` of ``tactile_image_cgan_figure4``.
    ratings : str
        Table of answers about the items in ``items.csv``.
    recipe : str
        Recipe of the generators; default: ``paper``, or ``quick`` for the bench.
    seed : int
        Seed of trainings and noise.
    """
    recipe = recipe or ("paper" if paper else "quick")
    seen = find_or_simulate(folder / "tactile_images", "tactile_images", given=images, progress=progress)
    plate_store = find_or_simulate(folder / "ultrasonic", "ultrasonic", given=data, progress=progress)
    generator = Path(signal_run) if signal_run else folder / "runs" / f"signals-{seed}"
    if not signal_run:
        options: dict[str, Any] = {"recipe": recipe, "by": "session", "changes": {"seed": seed}}
        trained_run("ultrasonic_cgan", plate_store, generator, **options, progress=progress)
    surfaces = generate_rated_surfaces(generator, seed=seed)
    plates = plates_of(plate_store)
    shown: dict[str, dict[str, Image]] = {}
    for weight in WEIGHTS:
        sight = (
            Path(image_runs) / f"weight-{weight}-{seed}"
            if image_runs
            else image_run(folder, seen, weight=weight, seed=seed, recipe=recipe, progress=progress)
        )
        drawn = draws_of(load_run(sight), plates, draws=1)
        shown[f"weight {weight}"] = {name: row[0] for name, row in zip(plates.names, drawn, strict=True)}
    met = [name for name in plates.names if name in surfaces.signals]
    if not met:
        raise ParameterError(f"no signal of any plate was made: {'; '.join(surfaces.failed.values())}")
    alone = {f"{WITHOUT_MODELS}/{n}": surfaces.straight[n] for n in met}
    alone |= {f"{WITHOUT_IMAGES}/{n}": surfaces.signals[n] for n in met}
    pairs = {f"{weight}/{n}": (surfaces.signals[n], held[n]) for weight, held in shown.items() for n in met}
    items = write_items(folder, {**alone, **pairs})
    if ratings:
        table, told_by = read_table(Path(ratings)).ratings, "people"
        tables = (table, table)
    else:
        tables, told_by = _simulated(alone, pairs), "simulated observers"
    targets = {name: surfaces.targets[name] for name in met}
    words = surfaces.ratings.words
    earlier = errors_of(tables[0].in_words(words), targets, (WITHOUT_MODELS, WITHOUT_IMAGES))
    later = errors_of(tables[1].in_words(words), targets, tuple(shown))
    of_three = (WITHOUT_MODELS, WITHOUT_IMAGES, f"weight {SHOWN}")
    errors = compare_cross_modal(earlier, later, words, shown=of_three)
    save_figure(
        folder / "figure5.png",
        overall_figure(errors, against=WITHOUT_IMAGES, published=PUBLISHED, told_by=told_by),
    )
    save_figure(folder / "figure6.png", per_word_figure(errors, of_three, told_by=told_by))
    result: dict[str, Any] = {
        "figures": [str(folder / "figure5.png"), str(folder / "figure6.png")],
        "items": str(items),
        "told_by": told_by,
        "simulated": seen.simulated or plate_store.simulated or not ratings,
        "recipe": recipe,
        "seed": seed,
        "images": origin_of(seen),
        "plates": origin_of(plate_store) | {"judged": met, "failed": dict(surfaces.failed)},
        "people_in_both_groups": sorted(_people(tables[0], earlier) & _people(tables[1], later)),
        **errors.as_dict(),
        "improved_words": {name: errors.improved(name, WITHOUT_MODELS) for name in of_three[1:]},
        "published": {
            "errors": PUBLISHED,
            "better_than_without_images": list(PUBLISHED_BETTER),
            "improved_words": {"without images": PUBLISHED_WORDS[0], "with images": PUBLISHED_WORDS[1]},
            "not_improved_with_images": list(PUBLISHED_WORDS[2]),
        },
    }
    return result | {"text": _text(result, errors)}


def _people(table: Ratings, conditions: Collection[str]) -> set[str]:
    return {
        rater
        for rater, item in zip(table.rater, table.item, strict=True)
        if item.partition("/")[0] in conditions
    }


def _simulated(
    alone: Mapping[str, Signal], pairs: Mapping[str, tuple[Signal, Image]]
) -> tuple[Ratings, Ratings]:
    """Return the ratings of two groups of simulated people, who took no part in the training data."""
    earlier, later = (
        draw_people(PEOPLE, seed=seed, prefix=name) for seed, name in ((1, "judge"), (2, "viewer"))
    )
    return score_vibrations(alone, earlier, seed=0), score_together(pairs, later, seed=0)


def _text(result: Mapping[str, Any], errors: CrossModalResult) -> str:
    table = [("", "MAE", "SE", "n", "published", "p as printed", "p by person")]
    for name, row in errors.overall.items():
        published = f"{PUBLISHED[name]:.1f}" if name in PUBLISHED else "–"
        printed = "" if name == WITHOUT_IMAGES else f"{errors.as_printed.pair(name, WITHOUT_IMAGES).p:.2g}"
        person = errors.against_earlier.get(name, {}).get(WITHOUT_IMAGES)
        by_person = "" if person is None else f"{person:.2g}"
        table.append((name, f"{row.mean:.3f}", f"{row.se:.3f}", str(row.n), published, printed, by_person))
    lines = [
        f"Figs. 5 and 6, rated by {result['told_by']}, recipe {result['recipe']}, "
        f"{len(result['plates']['judged'])} plates; mean absolute error, points of 7",
        columns(table),
    ]
    better = [
        name
        for name in errors.against_earlier
        if errors.overall[name].mean < errors.overall[WITHOUT_IMAGES].mean
        and errors.as_printed.pair(name, WITHOUT_IMAGES).p < ALPHA
    ]
    overall = errors.by_person.overall
    lines += [
        "p against without images: as printed, Steel-Dwass (treats every answer as independent); by person, "
        "Mann-Whitney on people's means between the groups, Holm",
        f"below without images as printed: {', '.join(better) or 'none'} (published: weights 1, 1,000, 5,000)",
        f"among the four weights by person: Friedman p {overall[1]:.2g}; Wilcoxon with Holm: "
        if overall
        else "",
    ]
    lines[-1] += ", ".join(f"{p.first} - {p.second} {p.p:.2g}" for p in errors.by_person.pairs)
    for name, words in result["improved_words"].items():
        count = PUBLISHED_WORDS[0] if name == WITHOUT_IMAGES else PUBLISHED_WORDS[1]
        lines.append(
            f"words improved over without models, {name}: {len(words)} ({', '.join(words) or 'none'}; "
            f"published {count} of 10" + (")" if name == WITHOUT_IMAGES else ", not rugged and uneven)")
        )
    if same := result["people_in_both_groups"]:
        lines.append(
            f"{len(same)} people are in both groups: p by person treats them as different people and is unreliable"
        )
    if result["plates"]["failed"]:
        lines.append(
            f"no signal of {', '.join(result['plates']['failed'])}: the training of their cluster failed"
        )
    return "\n".join(lines)
