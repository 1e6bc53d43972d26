"""Distances of pictures in networks trained on photographs: LPIPS, FID, and distances in EfficientNet-Lite0.

**The protocol** of all: pictures of one channel in [-1, 1], resized to 256 x 256 (bilinear) if they have another
size, grey as red, green and blue alike (no colour map); colour images keep their channels. LPIPS (Zhang et al. 2018)
takes these; FID (Heusel et al. 2017) takes them rounded to 8 bits. Published figures on tactile spectrograms name no
protocol, and a colour map alone changes them: compare only figures of one protocol.

LPIPS and the Inception network of FID are those of torchmetrics and torch-fidelity. Their weights are read from a
local file or torch's cache. Missing weights are an error, never a replacement: `TrunkDistance` needs no file, but is
neither LPIPS nor FID.

- Zhang, R. et al. (2018). The unreasonable effectiveness of deep features as a perceptual metric. CVPR.
- Heusel, M. et al. (2017). GANs trained by a two time-scale update rule converge to a local Nash equilibrium. NeurIPS.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.errors import DataError, ParameterError
from tactogram.evaluation.measures.embedding import frechet_distance
from tactogram.nn.trunks import Trunk
from tactogram.nn.vision_import import vision_module
from tactogram.nn.weight_files import ALEXNET, INCEPTION, read_weights, weight_file

SIZE = 256
"""Rows and columns of evaluated pictures: the paper's."""
BATCH = 32
PROTOCOL = (
    f"pictures of one channel in [-1, 1], bilinear to {SIZE} x {SIZE}, grey as red, green and blue; LPIPS: AlexNet, "
    "torchmetrics' linear heads; FID: 8 bits, Inception of torch-fidelity, 2048 features"
)


class Lpips:
    """LPIPS with AlexNet.

    ``weights`` is torchvision's AlexNet file, by default in torch's cache; ``option`` names that parameter in errors.
    Raises `MissingExtraError` without the extra ``vision``, and `DataError` if the weights are missing or unsuitable.
    """

    def __init__(self, weights: Path | str = "", *, option: str = "alexnet") -> None:
        library = vision_module("torchmetrics.functional.image.lpips")
        file = weight_file(weights, ALEXNET, option=option)
        state = read_weights(file)
        with torch.random.fork_rng(devices=()):
            torch.manual_seed(0)
            self._network: nn.Module = library._NoTrainLpips(net="alex", pnet_rand=True)
        # torchmetrics splits AlexNet's features into five slices that keep the number of each layer.
        names = {name: f"features.{name.partition('.')[2]}" for name in self._network.net.state_dict()}
        _load(self._network.net, {name: state.get(old) for name, old in names.items()}, file, "AlexNet")

    def __call__(self, real: Tensor, made: Tensor) -> Tensor:
        """Return the distance of each pair, shape (pair,), >= 0, of pictures (pair, 1, rows, columns) in [-1, 1]."""
        check_pictures(real, made, paired=True)
        with torch.no_grad():
            pairs = zip(_batches(real), _batches(made), strict=True)
            return torch.cat([self._network.to(a.device)(a, b).flatten() for a, b in pairs])


class Fid:
    """FID with torch-fidelity's Inception network, which defines it.

    ``weights`` is torch-fidelity's file, by default in torch's cache. ``random`` draws them from seed 0 instead, for
    tests: the distances are meaningless. Errors are those of `Lpips`.
    """

    def __init__(self, weights: Path | str = "", *, random: bool = False) -> None:
        library = vision_module("torchmetrics.image.fid").NoTrainInceptionV3
        state = None
        if not random:
            file = weight_file(weights, INCEPTION, option="inception")
            state = read_weights(file)

        class Inception(library):  # type: ignore[valid-type,misc]
            """Inception without the library's unpickling, which could run code: `read_weights` reads the file."""

            def load_state_dict(self, _: Mapping[str, Any], **options: Any) -> Any:
                if state is not None:
                    _load(super(), state, file, "torch-fidelity's Inception", **options)

        with tempfile.TemporaryDirectory() as folder, torch.random.fork_rng(devices=()):
            torch.manual_seed(0)
            empty = Path(folder) / "empty.pth"
            torch.save({}, empty)
            self._network: nn.Module = Inception("inception-v3-compat", ["2048"], str(empty))

    def features(self, pictures: Tensor) -> NDArray[np.float64]:
        """Return 2048 features of each picture, float64, shape (picture, 2048)."""
        check_pictures(pictures)
        features = []
        with torch.no_grad():
            for batch in _batches(pictures):
                eight_bit = ((batch + 1) * 127.5).round().clamp(0, 255).to(torch.uint8)
                features.append(self._network.to(batch.device)(eight_bit).double().cpu())
        return torch.cat(features).numpy()

    def __call__(self, real: Tensor, made: Tensor) -> float:
        """Return the distance, >= 0, of two sets of at least 2 pictures; few pictures bias it upwards."""
        return frechet_distance(self.features(real), self.features(made))


class TrunkDistance:
    """Distances in EfficientNet-Lite0, whose weights are part of a package of the extra ``vision``."""

    def __init__(self) -> None:
        self._trunk = Trunk("efficientnet_lite0")
        self._trunk.load()
        self._last: list[tuple[Tensor, Tensor]] = []

    def paired(self, real: Tensor, made: Tensor) -> Tensor:
        """Return 1 - the cosine of the last maps, mean over places, shape (pair,); 0 to 2."""
        check_pictures(real, made, paired=True)
        return 1 - F.cosine_similarity(self._maps(real), self._maps(made)).mean((1, 2))

    def frechet(self, real: Tensor, made: Tensor) -> float:
        """Return the Fréchet distance of two sets in the `features`, >= 0."""
        return frechet_distance(self.features(real), self.features(made))

    def features(self, pictures: Tensor) -> NDArray[np.float64]:
        """Return the last maps' means over places, float64, shape (picture, 1280)."""
        check_pictures(pictures)
        features: NDArray[np.float64] = self._maps(pictures).mean((2, 3)).double().cpu().numpy()
        return features

    def _maps(self, pictures: Tensor) -> Tensor:
        """Return the last maps, (picture, 1280, 8, 8); those of the last two sets are cached for the other distance."""
        for cached, maps in self._last:
            if cached is pictures:
                return maps
        with torch.no_grad():
            maps = torch.cat([self._trunk.to(batch.device).maps(batch) for batch in _batches(pictures)])
        self._last = [*self._last[-1:], (pictures, maps)]
        return maps


def check_pictures(*sets: Tensor, paired: bool = False) -> None:
    """Check that sets are (picture, 1 or 3, rows, columns) in [-1, 1], and, if ``paired``, of one shape."""
    for pictures in sets:
        if pictures.ndim != 4 or pictures.shape[1] not in (1, 3) or not len(pictures):
            raise ParameterError.must(
                "pictures", "be (picture, 1, rows, columns), or 3 for colours", tuple(pictures.shape)
            )
        if not bool((pictures.abs() <= 1 + 1e-6).all()):
            raise ParameterError.must("pictures", "be finite and in -1..1, got a value that is not")
    if paired and len({pictures.shape for pictures in sets}) > 1:
        shapes = " and ".join(str(tuple(pictures.shape)) for pictures in sets)
        raise ParameterError(f"pairs need as many pictures of one size, got {shapes}")


def _batches(pictures: Tensor) -> Iterator[Tensor]:
    """Yield pictures in the form of the protocol, float32, shape (at most `BATCH`, 3, SIZE, SIZE)."""
    for start in range(0, len(pictures), BATCH):
        batch = pictures[start : start + BATCH].float()
        if batch.shape[-2:] != (SIZE, SIZE):  # resizing to the same size changes nothing, slowly
            batch = F.interpolate(batch, (SIZE, SIZE), mode="bilinear", antialias=True)
        yield batch.clamp(-1, 1).expand(-1, 3, -1, -1)


def _load(network: Any, state: Mapping[str, Tensor | None], file: Path, name: str, **options: Any) -> None:
    try:
        network.load_state_dict(state, **options)
    except (RuntimeError, AttributeError) as error:
        line = " ".join(str(error).split())
        raise DataError(file, f"not weights of {name}: {line[:120]}") from error
