"""Attention maps of a picture generator: Grad-CAM, as Neshov et al. 2026 use it (Sec. 4.4, Figure 4).

Selvaraju, R. R. et al. (2017). Grad-CAM: visual explanations from deep networks via gradient-based localization. ICCV.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.nn.vision_import import vision_module


def attention_layer(generator: nn.Module) -> nn.ConvTranspose2d:
    """Return the last transposed convolution that gives several channels; `ParameterError` if there is none.

    The paper names the last one. In its generator that gives one channel, whose Grad-CAM is the picture itself before
    its last nonlinearity, up to sign and scale, whatever the generator has learnt.
    """
    layers = [
        module
        for module in generator.modules()
        if isinstance(module, nn.ConvTranspose2d) and module.out_channels > 1
    ]
    if not layers:
        raise ParameterError(
            f"attention maps need a transposed convolution to several channels, {type(generator).__name__} has none"
        )
    return layers[-1]


def attention_note(generator: nn.Module) -> str:
    """Return the name of `attention_layer` for figures."""
    layers = [module for module in generator.modules() if isinstance(module, nn.ConvTranspose2d)]
    layer = attention_layer(generator)
    number = layers.index(layer) + 1
    return f"transposed convolution {number} of {len(layers)}, {layer.out_channels} channels"


def attention_maps(generator: nn.Module, photo: Tensor, *conditions: Tensor) -> Tensor:
    """Return the Grad-CAM of generated pictures in `attention_layer`.

    The gradients of a picture's sum are averaged over places to one weight per map; the weighted sum of the maps is
    scaled to 0..1 by its smallest and largest value (Sec. 4.4, which mentions no rectification).

    Raises `ParameterError` or `MissingExtraError` if ``generator`` has no such layer; if captum of the extra ``vision``
    is not installed.

    Parameters
    ----------
    generator : nn.Module
        Called as ``generator(photo, *conditions)``; one picture per photo. Set it to ``eval`` first.
    photo : float tensor, shape (photo, channel, row, column)
    conditions : tensor, shape (photo, ...)
        Further inputs, e.g. labels.

    Returns
    -------
    float32 tensor, shape (photo, row, column) of the picture, in 0..1
        All 0 where a map is flat.
    """
    size: list[int] = []

    def total(photo: Tensor, *conditions: Tensor) -> Tensor:
        picture: Tensor = generator(photo, *conditions)
        size[:] = picture.shape[-2:]
        return picture.flatten(1).sum(1)

    cam = vision_module("captum.attr").LayerGradCam(total, attention_layer(generator))
    maps = cam.attribute(photo, additional_forward_args=conditions or None)
    maps = F.interpolate(maps.detach().float(), size, mode="bilinear")[:, 0]
    least, most = maps.amin((1, 2), keepdim=True), maps.amax((1, 2), keepdim=True)
    return torch.where(most > least, (maps - least) / (most - least).clamp_min(1e-30), torch.zeros_like(maps))
