"""Quantisation of an ONNX file to 8-bit weights by onnxruntime."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

CONVOLUTIONS = {"Conv", "ConvTranspose"}
MULTIPLICATIONS = {"MatMul", "Gemm"}


def quantise(file: Path, out: Path, inputs: Sequence[Mapping[str, NDArray[Any]]]) -> str:
    """Write the quantised form of ``file``, and return the method, ``"dynamic"`` or ``"static"``.

    Convolutions need ranges that are measured beforehand, on ``inputs``: static. Without them, the ranges of a matrix
    product are those of each input: dynamic. Weights use seven of the eight bits: a processor without VNNI adds pairs
    of products in 16 bits, which eight would overflow.
    """
    import onnx
    from onnxruntime.quantization import QuantFormat, QuantType, quantize_dynamic, quantize_static
    from onnxruntime.quantization.shape_inference import quant_pre_process

    prepared = out.with_suffix(".prepared")
    try:
        quant_pre_process(str(file), str(prepared), skip_symbolic_shape=True)
        kinds = {node.op_type for node in onnx.load(str(prepared), load_external_data=False).graph.node}
        if not kinds & CONVOLUTIONS:
            quantize_dynamic(
                str(prepared), str(out), weight_type=QuantType.QInt8, per_channel=True, reduce_range=True
            )
            return "dynamic"
        quantize_static(
            str(prepared),
            str(out),
            _Inputs(inputs),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=sorted(kinds & (CONVOLUTIONS | MULTIPLICATIONS)),
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            per_channel=True,
            reduce_range=True,
        )
        return "static"
    finally:
        prepared.unlink(missing_ok=True)


class _Inputs:
    """Calibration data as onnxruntime reads it."""

    def __init__(self, inputs: Sequence[Mapping[str, NDArray[Any]]]) -> None:
        self.inputs: Iterator[Mapping[str, NDArray[Any]]] = iter(inputs)

    def get_next(self) -> dict[str, NDArray[Any]] | None:
        """Return the next inputs, or None after the last."""
        found = next(self.inputs, None)
        return None if found is None else dict(found)
