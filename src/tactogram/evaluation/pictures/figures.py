"""Figures of pictures of touch (real, generated, attention, the worst), and of generated images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.figures import plot_losses
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.signal import Image
from tactogram.signal.figure import unit_text

COLOURS = "magma"
"""As in all spectrograms of this project; jet, as in the paper, shows edges that the data does not have."""


@dataclass(frozen=True, eq=False)
class PictureCase:
    """Photo of a place, and its real and generated pictures."""

    title: str
    """For example the material."""
    photo: Tensor
    """Shape (channel, row, column), in [-1, 1]."""
    pictures: Mapping[str, Tensor]
    """Pictures by kind, e.g. ``{"real": …, "generated": …}``, shape (1, row, column), in [-1, 1]."""
    attention: Mapping[str, Tensor] | None = None
    """Maps over some of ``pictures``, by their names, shape (row, column), 0..1."""
    note: str = ""
    """Line below the title, e.g. the error."""


def pictures_figure(
    cases: Sequence[PictureCase],
    picture: SpectrogramPicture,
    *,
    title: str = "",
    attention_notes: Mapping[str, str] | None = None,
) -> Figure:
    """Draw a row per case: photo, pictures and attention maps, as in Figures 3 to 5 of the paper.

    All share one scale of levels, in dB re 1 unit. Attention is drawn over its picture in jet, as published.
    ``attention_notes`` are captions of the attention maps, by the names of their pictures (`attention_note`). Raises
    `ParameterError` without a case, or if the names of the pictures differ between cases.
    """
    if not cases:
        raise ParameterError("at least one case is needed, got none")
    names, maps = list(cases[0].pictures), list(cases[0].attention or {})
    for case in cases:
        if list(case.pictures) != names or list(case.attention or {}) != maps:
            raise ParameterError(
                f"all cases must have pictures {', '.join(names)}, got those of {case.title}"
            )
    columns = 1 + len(names) + len(maps)
    figure = Figure(figsize=(1.5 + 1.6 * columns, 0.7 + 1.6 * len(cases)), layout="constrained")
    grid = figure.subplots(len(cases), columns, squeeze=False)
    for row, case in zip(grid, cases, strict=True):
        _photo(row[0], case)
        for axes, name in zip(row[1:], names, strict=False):
            mesh = _picture(axes, case.pictures[name], picture)
        for axes, name in zip(row[1 + len(names) :], maps, strict=True):
            _picture(axes, case.pictures[name], picture, grey=True)
            _overlay(axes, (case.attention or {})[name], picture)
    notes = attention_notes or {}
    attention = (f"attention, {name}\n{fill(notes.get(name, ''), 26)}".strip() for name in maps)
    for axes, name in zip(grid[0], ["photo", *names, *attention], strict=True):
        axes.set_title(name, fontsize=8)
    for axes in grid[:-1].flat:
        axes.set_xticklabels([])
    for axes in grid[:, 2:].flat:
        axes.set_yticklabels([])
    for axes in grid[-1, 1:]:
        axes.set_xlabel("time, s" if picture.domain == "time" else "displacement, mm", fontsize=7)
    for axes in grid[:, 1]:
        axes.set_ylabel("Hz" if picture.domain == "time" else "1/mm", fontsize=7)
    figure.colorbar(mesh, ax=grid[:, -1], fraction=0.08, pad=0.02, label=f"dB re 1 {unit_text(picture.unit)}")
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def worst_cases(
    errors: Sequence[float] | NDArray[np.float64], materials: Sequence[str], *, count: int = 3
) -> list[int]:
    """Return the indices of the ``count`` largest errors, one per material, the largest first.

    An objective selection: Figure 5 of the paper shows "the most challenging" cases of three classes. ``errors``, shape
    (case,), are any distances of pairs, e.g. LPIPS or L1. Raises `ParameterError` unless they are finite and as many as
    ``materials``.
    """
    values = np.asarray(errors, np.float64)
    if values.shape != (len(materials),) or not np.isfinite(values).all():
        raise ParameterError.must(
            "errors", f"be finite and as many as cases ({len(materials)})", values.shape
        )
    worst: dict[str, int] = {}
    for index in np.argsort(-values, kind="stable"):
        worst.setdefault(materials[index], int(index))
    return list(worst.values())[:count]


def failures_figure(
    cases: Sequence[PictureCase], errors: Sequence[float], picture: SpectrogramPicture, *, measure: str
) -> Figure:
    """Draw the cases with the largest errors by ``measure``, one per material (`worst_cases`); titles are materials."""
    chosen = worst_cases(errors, [case.title for case in cases])
    median = float(np.median(np.asarray(errors, np.float64)))
    shown = [replace(cases[index], note=f"{errors[index]:.3g} (median {median:.3g})") for index in chosen]
    return pictures_figure(shown, picture, title=f"Largest {measure} of {len(cases)} cases, one per material")


def _photo(axes: Axes, case: PictureCase) -> None:
    pixels = ((case.photo.detach().cpu().numpy() + 1) / 2).clip(0, 1)
    axes.imshow(pixels.transpose(1, 2, 0), cmap="gray", vmin=0, vmax=1)  # colours ignore the map
    axes.set(xticks=[], yticks=[])
    axes.set_ylabel("\n".join([fill(case.title, 18), case.note]).strip(), fontsize=7)


def _picture(axes: Axes, pixels: Tensor, picture: SpectrogramPicture, *, grey: bool = False) -> Any:
    share = (pixels.detach().cpu().numpy()[0] + 1) / 2
    axes.tick_params(labelsize=6, length=2)
    return axes.imshow(
        picture.floor_db + (picture.ceiling_db - picture.floor_db) * share,
        origin="lower",
        aspect="auto",
        cmap="gray" if grey else COLOURS,
        vmin=picture.floor_db,
        vmax=picture.ceiling_db,
        extent=_extent(picture),
    )


def _overlay(axes: Axes, attention: Tensor, picture: SpectrogramPicture) -> None:
    axes.imshow(
        attention.detach().cpu().numpy(),
        origin="lower",
        aspect="auto",
        cmap="jet",
        vmin=0,
        vmax=1,
        alpha=0.5,
        extent=_extent(picture),
    )


def _extent(picture: SpectrogramPicture) -> tuple[float, float, float, float]:
    return (0.0, picture.length / picture.rate, 0.0, picture.rate / 2)


@dataclass(frozen=True, eq=False)
class GeneratorRow:
    """Images and losses of a generator, a row of a figure."""

    title: str
    trials: Sequence[Sequence[Image]]
    """Per noise, the image of each label."""
    losses: Mapping[str, Sequence[tuple[int, float]]]
    """Update and loss, by the network's name."""


def generated_figure(rows: Sequence[GeneratorRow], labels: Sequence[str], *, title: str = "") -> Figure:
    """Draw, per generator, the images of each label from two or more noises, and the losses: Fig. 4 of the paper.

    ``labels`` names the intended impression of each image, e.g. a plate. Raises `ParameterError` if there is no row, or
    a trial has another number of images than ``labels``.
    """
    if not rows:
        raise ParameterError("at least one generator is needed, got none")
    for row in rows:
        if any(len(trial) != len(labels) for trial in row.trials):
            raise ParameterError(f"{row.title}: each trial needs {len(labels)} images, one per label")
    across = 6
    down = -(-len(labels) // across)
    trials = len(rows[0].trials)
    figure = Figure(
        figsize=(1.1 * across * trials + 4.2, 0.4 + len(rows) * (1.12 * down + 0.45)), layout="constrained"
    )
    if title:
        figure.suptitle(title, fontsize=11)
    parts = figure.subfigures(len(rows), 1, squeeze=False)
    for part, row in zip(parts.ravel(), rows, strict=True):
        part.suptitle(row.title, fontsize=10, x=0.01, ha="left")
        cells = part.subfigures(1, trials + 1, width_ratios=[1.1 * across] * trials + [4.2])
        for number, (cell, trial) in enumerate(zip(cells[:-1], row.trials, strict=True), start=1):
            places = cell.subplots(down, across, squeeze=False).ravel()
            for axes in places:
                axes.axis("off")
            for axes, image, label in zip(places, trial, labels, strict=False):
                axes.imshow(image.pixels, interpolation="nearest")
                axes.set_title(label, fontsize=7, pad=2)
            places[0].text(
                -0.18,
                0.5,
                f"noise {number}",
                rotation=90,
                va="center",
                ha="center",
                fontsize=7,
                transform=places[0].transAxes,
            )
        curves = cells[-1].subplots()
        plot_losses(curves, row.losses)
        curves.set_xlabel("update", fontsize=8)
        curves.set_ylabel("loss", fontsize=8)
        curves.set_ylim(bottom=0)
        curves.tick_params(labelsize=7)
        curves.legend(fontsize=7)
    return figure
