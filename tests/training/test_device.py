"""Number format of a training, by what the machine multiplies fast."""

import pytest
import torch

from tactogram.training.device import chosen_precision


@pytest.mark.parametrize(("amx", "expected"), [(True, "bf16-mixed"), (False, "32-true")])
def test_a_processor_with_matrix_units_takes_bfloat16(monkeypatch, amx, expected):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: {"amx_bf16": amx})
    assert chosen_precision("auto") == expected
    monkeypatch.setattr(torch.cpu, "get_capabilities", dict)  # processors of other makers
    assert chosen_precision("auto") == "32-true"


@pytest.mark.parametrize(("fast", "expected"), [(True, "bf16-mixed"), (False, "32-true")])
def test_a_gpu_takes_it_if_it_does_so_itself(monkeypatch, fast, expected):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "is_bf16_supported", lambda including_emulation: fast)
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: {"amx_bf16": not fast})
    assert chosen_precision("auto") == expected
    assert chosen_precision("auto", accelerator="cpu") != expected


def test_what_a_recipe_names_is_taken():
    assert chosen_precision("16-mixed") == "16-mixed"
