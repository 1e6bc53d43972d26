"""Evaluation report of a generator: figures, tables and sounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure

from tactogram.evaluation.figures import spectra_figure
from tactogram.evaluation.generation.comparison import (
    CEILING,
    FLOOR,
    MODEL,
    NEAREST,
    GenerationResult,
    MeasureInfo,
    describe_measures,
)
from tactogram.evaluation.generation.spectrogram_figures import spectrograms_figure
from tactogram.evaluation.report import (
    Block,
    ReportFigure,
    ReportSection,
    ReportSound,
    ReportTable,
    ReportText,
)
from tactogram.signal import Signal
from tactogram.statistics.figures import INK

BySet = Mapping[str, Sequence[Signal]]

COLOURS = {MODEL: "#2166ac", "ar_texture": "#d6604d", "replay": "#4d9221"}
FURTHER = ("#8073ac", "#b35806", "#666666")
NEAR, FAR = "#2166ac", "#b2182b"
MARKERS = "osD^vPX"
DRAWN = (-0.5, 1.5)
"""Range of the positions in figures; values beyond it are drawn at the edge."""
MOST_SHOWN = 24
"""Largest number of materials with figures and sounds, which bounds the size of the page."""
HEARD_S = 3.0
SIDE_BY_SIDE = 3
"""Pairs of spectrograms in a figure, as in Figures 7 to 9 of Saga et al. 2020."""


def generation_sections(
    result: GenerationResult, recorded: BySet, sets: Mapping[str, BySet]
) -> list[ReportSection]:
    """Return the sections of a report on ``result``, with the test recordings and the evaluated sets by column."""
    return [
        ReportSection("Summary", _summary(result)),
        ReportSection("Every material, every measure", _overview(result)),
        ReportSection("Comparison with the baselines", _comparison(result)),
        ReportSection("Examples to view and listen to", _examples(result, recorded, sets)),
        ReportSection("Protocol", _protocol(result)),
        ReportSection("All values", [_per_measure(result, name) for name in result.values]),
    ]


def position_figure(result: GenerationResult) -> Figure:
    """Draw the positions of the model and the baselines: a row per measure, 0 at the floor and 1 at the ceiling.

    Small dots are the model's materials, large markers the positions of means over materials.
    """
    names, titles = list(result.values), [info.title for info in _measures(result).values()]
    figure = Figure(figsize=(9, 1.1 + 0.3 * len(names)), layout="constrained")
    axes = figure.add_subplot()
    axes.axvspan(0, 1, color="#eef1f4", lw=0)
    for position in (0, 1):
        axes.axvline(position, color="#9aa4ae", lw=0.8)
    rng = np.random.default_rng(0)
    for row, name in enumerate(names):
        positions = np.array([result.position(name, material) for material in result.materials], float)
        defined = positions[~np.isnan(positions)]
        axes.scatter(
            np.clip(defined, *DRAWN), row + rng.uniform(-0.16, 0.16, len(defined)), s=7, alpha=0.35, lw=0,
            color=_colour(MODEL, result),
        )  # fmt: skip
    for column, marker in zip((MODEL, *_others(result)), MARKERS, strict=False):
        means = np.array([result.position(name, column=column) for name in names], float)  # None becomes NaN
        axes.scatter(
            np.clip(means, *DRAWN), range(len(names)), s=60 if column == MODEL else 32, marker=marker,
            color=_colour(column, result), label=column, edgecolor="white", lw=0.6, zorder=3 + (column == MODEL),
        )  # fmt: skip
    axes.set_yticks(range(len(names)), [title.split(":")[0] for title in titles], fontsize=8)
    axes.set(xlim=(DRAWN[0] - 0.05, DRAWN[1] + 0.05), ylim=(len(names) - 0.4, -0.6))
    axes.set_xticks(
        [-0.5, 0, 0.5, 1, 1.5], ["", "floor\nother real recordings", "", "ceiling\nother materials", ""]
    )
    axes.tick_params(length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, 1.0 + 0.9 / len(names)), ncols=7, frameon=False, fontsize=8
    )
    return figure


def overview_figure(result: GenerationResult) -> Figure:
    """Draw positions as a map, a row per material, a column per measure; grey where a measure is undecided."""
    names, materials = list(result.values), (None, *result.materials)
    # None becomes NaN.
    positions = np.array([[result.position(name, m) for name in names] for m in materials], float)
    figure = Figure(figsize=(2.2 + 0.46 * len(names), 2.6 + 0.24 * len(materials)), layout="constrained")
    axes = figure.add_subplot()
    colours: Colormap = LinearSegmentedColormap.from_list(
        "positions", [NEAR, "#92c5de", "#f7f7f7", "#f4a582", FAR]
    )
    colours = colours.with_extremes(bad="#e3e6e9")
    picture = axes.imshow(positions, cmap=colours, vmin=0, vmax=1, aspect="auto")
    bar = figure.colorbar(picture, ax=axes, fraction=0.03, pad=0.02)
    bar.set_ticks([0, 0.5, 1], labels=["floor", "half-way", "ceiling"])
    bar.ax.tick_params(labelsize=7, length=0)
    axes.set_xticks(range(len(names)), [_short(name) for name in names], rotation=55, ha="right", fontsize=7)
    axes.set_yticks(range(len(materials)), ["overall", *result.materials], fontsize=7)
    axes.axhline(0.5, color="white", lw=3)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    for (row, column), value in np.ndenumerate(positions):
        if np.isnan(value):
            axes.text(column, row, "–", ha="center", va="center", fontsize=6, color="#57606a")
        else:
            text = f"{value:.1f}".replace("-0.0", "0.0") if abs(value) < 9.95 else f"{value:.0f}"
            dark = value < 0.2 or value > 0.85
            axes.text(
                column, row, text, ha="center", va="center", fontsize=6, color="white" if dark else INK,
                fontweight="bold" if row == 0 else "normal",
            )  # fmt: skip
    return figure


def _summary(result: GenerationResult) -> list[Block]:
    verdicts = [result.verdict(name, material) for name, rows in result.values.items() for material in rows]
    decided = len(verdicts) - verdicts.count("undecided")
    text = (
        f"{result.summary} Of {decided} values ({len(result.values)} measures of {len(result.materials)} materials"
        f"{', without those that do not separate materials' if decided < len(verdicts) else ''}) "
        f"{verdicts.count('floor')} are at the floor or better, {verdicts.count('between')} between floor and "
        f"ceiling, {verdicts.count('beyond')} beyond the ceiling."
    )
    measures = _measures(result)
    for baseline in _others(result):
        if worse := result.worse_than(baseline):
            text += f" Worse than {baseline} in {_listed([_short(name) for name in worse])}."
        else:
            text += f" Nowhere worse than {baseline}."
    rows = []
    for name, row in result.overall.items():
        interval = result.interval(name)
        rows.append(
            (
                measures[name].title, measures[name].unit, row[MODEL],
                _range(*interval) if interval else "–",
                row[FLOOR], row[CEILING], *(row[b] for b in result.baselines),
                "↑" if result.better[name] == "higher" else "↓",
            )
        )  # fmt: skip
    header = ("measure", "unit", MODEL, "95 %", FLOOR, CEILING, *result.baselines, "better")
    caption = (
        "Means over materials. Floor: real recordings against other real recordings of the same material. Ceiling: "
        "other materials (for accuracies: chance; for memorisation: the training data itself). 95 %: for accuracies "
        "Wilson's, by recordings; otherwise Student's, over materials."
    )
    return [
        ReportText(text),
        ReportFigure(
            partial(position_figure, result),
            "Positions of the model and the baselines. Dots: the model's materials. "
            "Values farther out are drawn at the edge.",
        ),
        ReportTable(header, rows, caption),
    ]


def _overview(result: GenerationResult) -> list[Block]:
    caption = (
        "0: at the floor, like real recordings; 1: at the ceiling, like another material. Grey: undecided, since other "
        "materials are no farther from this one than its own recordings are from each other."
    )
    blocks: list[Block] = [ReportFigure(partial(overview_figure, result), caption)]
    if beyond := result.beyond_ceiling():
        by_measure: dict[str, list[str]] = {}
        for name, material in beyond:
            by_measure.setdefault(name, []).append(material)
        measures = _measures(result)
        rows = [(measures[name].title, len(m), ", ".join(m)) for name, m in by_measure.items()]
        blocks.append(ReportTable(("beyond the ceiling", "number of materials", "materials"), rows))
    return blocks


def _comparison(result: GenerationResult) -> list[Block]:
    blocks: list[Block] = []
    measures = _measures(result)
    for baseline in _others(result):
        rows = []
        for name in result.values:
            if gain := result.advantage(name, baseline):
                bounded = gain["low"] is not None
                sure = "yes" if bounded and not gain["low"] <= 0 <= gain["high"] else ""
                rows.append(
                    (
                        measures[name].title, gain["mean"],
                        _range(gain["low"], gain["high"]) if bounded else "–",
                        f"{gain['better_on']} of {gain['materials']}",
                        "better" if gain["mean"] > 0 else "worse" if gain["mean"] < 0 else "same", sure,
                    )
                )  # fmt: skip
        header = (f"against {baseline}", "gain", "95 %", "better on", "the model is", "beyond chance")
        caption = (
            "Gain: by how much the model is better, mean over materials. "
            "95 %: Student's interval over materials, paired."
        )
        blocks.append(ReportTable(header, rows, caption))
    return blocks or [ReportText("No baseline was evaluated.")]


def _examples(result: GenerationResult, recorded: BySet, sets: Mapping[str, BySet]) -> list[Block]:
    blocks: list[Block] = [
        ReportText(
            "Spectra are means with their range from smallest to largest. Sounds are played at full scale."
        )
    ]
    shown_materials = result.materials[:MOST_SHOWN]
    for start in range(0, len(shown_materials), SIDE_BY_SIDE):
        some = {
            material: _cut_to_shortest(recorded=recorded[material][0], generated=sets[MODEL][material][0])
            for material in shown_materials[start : start + SIDE_BY_SIDE]
        }
        caption = "Recorded and generated, each pair scaled to its largest value per axis, for display only."
        blocks.append(ReportFigure(partial(spectrograms_figure, some), caption))
    for material in shown_materials:
        groups = {"recorded": recorded[material]}
        groups |= {("generated" if c == MODEL else c): part[material] for c, part in sets.items()}
        blocks.append(ReportFigure(partial(spectra_figure, groups), material))
        for name, signals in groups.items():
            shown = signals[0].cut(0, max(1, round(HEARD_S * signals[0].rate)))
            blocks.append(ReportSound(shown, f"{material}, {name}"))
    if len(result.materials) > MOST_SHOWN:
        blocks.append(ReportText(f"The first {MOST_SHOWN} of {len(result.materials)} materials are shown."))
    return blocks


def _cut_to_shortest(**signals: Signal) -> dict[str, Signal]:
    length = min(map(len, signals.values()))
    return {name: signal.cut(0, length) for name, signal in signals.items()}


def _protocol(result: GenerationResult) -> list[Block]:
    text = (
        f"Every set was cut to {result.count} pieces of {result.seconds:.3g} s per material. Floor and baselines use "
        "the training part and are compared with the test part. The embedding and the classifier are a stroke_cnn "
        "trained on the training part. In the two-sample accuracy, neighbours from a point's own recording do not "
        "count; 0.5 is chance: the sets cannot be distinguished."
    )
    return [ReportText(text), *(ReportText(note) for note in result.notes)]


def _per_measure(result: GenerationResult, name: str) -> ReportTable:
    columns = (MODEL, FLOOR, CEILING, NEAREST, *result.baselines)
    rows = [
        (material, *(row.get(column) for column in columns), result.position(name, material))
        for material, row in result.values[name].items()
    ]
    header = ("material", *(column.replace("_", " ") for column in columns), "position")
    measure = _measures(result)[name]
    title = f"{measure.title}, {measure.unit}" if measure.unit else measure.title
    return ReportTable(header, rows, f"{name}; {result.better[name]} is better.", folded=title)


def _others(result: GenerationResult) -> list[str]:
    rows = [row for rows in result.values.values() for row in rows.values()]
    return [name for name in result.baselines if any(row.get(name) != row.get(MODEL) for row in rows)]


def _measures(result: GenerationResult) -> dict[str, MeasureInfo]:
    measures = describe_measures()
    return {name: measures.get(name, MeasureInfo(name)) for name in result.values}


def _range(low: float, high: float) -> str:
    return f"{low:.3g}\u00a0–\u00a0{high:.3g}"


def _short(name: str) -> str:
    name = name.removesuffix("_db").replace("_distance", "").replace("_accuracy", "")
    return name.replace("memorised_share", "memorised").replace("_", " ")


def _colour(column: str, result: GenerationResult) -> str:
    if column in COLOURS:
        return COLOURS[column]
    return FURTHER[[c for c in result.columns if c not in COLOURS].index(column) % len(FURTHER)]


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
