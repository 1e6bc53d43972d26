import sys
from importlib.util import find_spec
from types import ModuleType

import pytest
import torch

from tactogram.errors import MissingExtraError
from tactogram.nn import vision_import
from tactogram.nn.vision_import import torchvision, vision_module

pytestmark = pytest.mark.skipif(find_spec("torchvision") is None, reason="the extra vision is not installed")


def test_densenet_comes_with_the_published_width():
    network = torchvision().models.densenet201(weights=None)
    assert network.classifier.in_features == 1920


def test_the_module_is_the_one_that_a_plain_import_then_gives():
    assert torchvision() is sys.modules["torchvision"]
    assert vision_module("torchvision.models") is torchvision().models


@pytest.mark.parametrize("name", ["torchmetrics.image", "torch_fidelity", "captum.attr"])
def test_packages_that_import_torchvision_can_be_imported(name):
    assert vision_module(name).__name__ == name


def test_a_missing_package_names_the_extra():
    with pytest.raises(MissingExtraError, match=r"no_such_package.*tactogram\[vision\]"):
        vision_module("no_such_package")


def test_missing_torchvision_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "torchvision", None)
    with pytest.raises(MissingExtraError, match=r"torchvision.*tactogram\[vision\]"):
        torchvision.__wrapped__()


def test_operators_that_do_not_load_are_declared_and_the_import_tried_again(monkeypatch):
    half, whole, tries = ModuleType("torchvision.half"), ModuleType("torchvision"), []

    def importing(name):
        tries.append(name)
        if len(tries) == 1:
            sys.modules["torchvision.half"] = half
            raise RuntimeError("operator torchvision::nms does not exist")
        assert "torchvision.half" not in sys.modules
        return whole

    # Loaded modules are restored afterwards.
    for name in [name for name in sys.modules if name.partition(".")[0] == "torchvision"]:
        monkeypatch.setitem(sys.modules, name, sys.modules[name])
    monkeypatch.setattr(vision_import, "_import", importing)
    monkeypatch.setattr(vision_import, "_declare_operators", lambda: tries.append("declared"))
    assert torchvision.__wrapped__() is whole
    assert tries == ["torchvision", "declared", "torchvision"]


def test_the_operators_exist_afterwards():
    torchvision()
    for name in vision_import.OPERATORS:
        assert str(getattr(torch.ops.torchvision, name).default._schema).endswith("-> Tensor")


@pytest.mark.parametrize("error", [RuntimeError("CUDA mismatch\nat length"), ImportError("no libc")])
def test_another_failure_is_one_line(monkeypatch, error):
    def importing(name):
        if name == "other":
            raise error
        return ModuleType(name)

    monkeypatch.setattr(vision_import, "_import", importing)
    with pytest.raises(MissingExtraError, match=r"other does not import .*matches torch") as caught:
        vision_module("other")
    assert "\n" not in str(caught.value)
