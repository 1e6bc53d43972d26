"""Attention maps of a picture generator: Grad-CAM, as Neshov et al. 2026 use it (Sec. 4.4, Figure 4).

References
----------
- Selvaraju, R. R. et al. (2017). Grad-CAM: visual explanations from deep networks via gradient-based localization.
  ICCV.
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
    """Return the transposed convolution of ``generator`` that is nearest to its output.

    Raises
    ------
    ParameterError
        If it has none.
    """
    found = [module for module in generator.modules() if isinstance(module, nn.ConvTranspose2d)]
    if not found:
        raise ParameterError(f"{type(generator).__name__} has no transposed convolution to look at")
    return found[-1]


def attention_note(generator: nn.Module) -> str:
    """Return what a figure must say of `attention_maps` as published; empty where the layer gives several maps.

    Raises
    ------
    ParameterError
        If ``generator`` has no transposed convolution.
    """
    only_one = last_transposed_convolution(generator).out_channels == 1
    return "the layer gives one channel: this is the picture itself" if only_one else ""


def attention_maps(
    generator: nn.Module,
    photo: Tensor,
    *given: Tensor,
    layer: nn.Module | None = None,
    activations: Activations = "output",
) -> Tensor:
    """Return the Grad-CAM of generated pictures.

    Gradients of the picture's sum are averaged over places to a weight per map, the maps summed with these, and each
    result brought to 0..1 by its least and largest value (Sec. 4.4; no rectification is named there).

    Parameters
    ----------
    generator : nn.Module
        Called as ``generator(photo, *given)``; one picture per photo. Its mode is kept: set ``eval`` first.
    photo : float tensor, shape (photo, channel, row, column)
    given : tensor, shape (photo, ...)
        What else it takes, e.g. labels.
    layer : nn.Module, optional
        By default `last_transposed_convolution`, as published.
    activations : {"output", "input"}
        Which maps of the layer. ``output`` is what is published; where the layer gives one channel, as in the
        paper's generator, that map is the picture before its last nonlinearity, up to sign and scale: `attention_note`
        says so. ``input`` shows the many maps that it is made of.

    Returns
    -------
    float32 tensor, shape (photo, row, column) of the picture, in 0..1
        All 0 where a map is flat.

    Raises
    ------
    MissingExtraError
        If captum is not installed; names the extra ``vision``.
    """
    if activations not in ("output", "input"):
        raise ParameterError(f"activations must be 'output' or 'input', got {activations!r}")
    size: list[int] = []

    def total(photo: Tensor, *given: Tensor) -> Tensor:
        picture: Tensor = generator(photo, *given)
        size[:] = picture.shape[-2:]
        return picture.flatten(1).sum(1)

    cam = vision_module("captum.attr").LayerGradCam(
        total, last_transposed_convolution(generator) if layer is None else layer
    )
    maps = cam.attribute(
        photo, additional_forward_args=given or None, attribute_to_layer_input=activations == "input"
    )
    maps = F.interpolate(maps.detach().float(), size, mode="bilinear")[:, 0]
    least, most = maps.amin((1, 2), keepdim=True), maps.amax((1, 2), keepdim=True)
    return torch.where(most > least, (maps - least) / (most - least).clamp_min(1e-30), torch.zeros_like(maps))
