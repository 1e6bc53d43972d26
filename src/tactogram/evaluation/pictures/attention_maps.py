"""Attention maps of a picture generator: Grad-CAM, as Neshov et al. 2026 use it (Sec. 4.4, Figure 4).

Selvaraju, R. R. et al. (2017). Grad-CAM: visual explanations from deep networks via gradient-based localization. ICCV.
"""

from __future__ import annotations

from typing import Literal

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.nn.vision_import import vision_module

Activations = Literal["output", "input"]


def last_transposed_convolution(generator: nn.Module) -> nn.ConvTranspose2d:
    """Return the transposed convolution nearest to the output; `ParameterError` if there is none."""
    layers = [module for module in generator.modules() if isinstance(module, nn.ConvTranspose2d)]
    if not layers:
        raise ParameterError(
            f"attention maps need a transposed convolution, {type(generator).__name__} has none"
        )
    return layers[-1]


def attention_note(generator: nn.Module) -> str:
    """Return the caveat for figures of `attention_maps` as published; empty if the layer has several channels."""
    only_one = last_transposed_convolution(generator).out_channels == 1
    return "the layer gives one channel: this is the picture itself" if only_one else ""


def attention_maps(
    generator: nn.Module, photo: Tensor, *conditions: Tensor, activations: Activations = "output"
) -> Tensor:
    """Return the Grad-CAM of generated pictures in `last_transposed_convolution`.

    The gradients of a picture's sum are averaged over places to one weight per map; the weighted sum of the maps is
    scaled to 0..1 by its smallest and largest value (Sec. 4.4, which mentions no rectification).

    Parameters
    ----------
    generator : nn.Module
        Called as ``generator(photo, *conditions)``; one picture per photo. Set it to ``eval`` first.
    photo : float tensor, shape (photo, channel, row, column)
    conditions : tensor, shape (photo, ...)
        Further inputs, e.g. labels.
    activations : {"output", "input"}
        Maps of the layer. ``output`` is as published; if the layer has one channel, as in the paper's generator,
        that map is the picture before its last nonlinearity, up to sign and scale (see `attention_note`). ``input``
        shows the maps that it is computed from.

    Returns
    -------
    float32 tensor, shape (photo, row, column) of the picture, in 0..1
        All 0 where a map is flat.

    Raises
    ------
    ParameterError, MissingExtraError
        If ``generator`` has no transposed convolution; if captum of the extra ``vision`` is not installed.
    """
    if activations not in ("output", "input"):
        raise ParameterError(f"activations must be 'output' or 'input', got {activations!r}")
    size: list[int] = []

    def total(photo: Tensor, *conditions: Tensor) -> Tensor:
        picture: Tensor = generator(photo, *conditions)
        size[:] = picture.shape[-2:]
        return picture.flatten(1).sum(1)

    cam = vision_module("captum.attr").LayerGradCam(total, last_transposed_convolution(generator))
    maps = cam.attribute(
        photo, additional_forward_args=conditions or None, attribute_to_layer_input=activations == "input"
    )
    maps = F.interpolate(maps.detach().float(), size, mode="bilinear")[:, 0]
    least, most = maps.amin((1, 2), keepdim=True), maps.amax((1, 2), keepdim=True)
    return torch.where(most > least, (maps - least) / (most - least).clamp_min(1e-30), torch.zeros_like(maps))
