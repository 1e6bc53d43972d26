"""The installation check."""

import json
from types import SimpleNamespace

import pytest

from tactogram.cli import main
from tactogram.workflows import doctor


def test_doctor_tells_versions_and_extras(capsys):
    assert main(["doctor", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["packages"]["torch"].startswith("2.")
    assert facts["extras"]["dev"] == {"for": "tests, style, types, benchmarks", "missing": []}
    assert "LPIPS" in facts["extras"]["vision"]["for"]
    assert facts["device"]


@pytest.mark.parametrize("compiled", [True, False])
def test_doctor_tells_whether_torchvision_has_its_compiled_operators(compiled, monkeypatch):
    extension = SimpleNamespace(_has_ops=lambda: compiled)
    monkeypatch.setattr("tactogram.nn.vision_import.vision_module", lambda name: extension)
    monkeypatch.setattr(doctor, "find_spec", lambda name: name == "torchvision" or None)
    said = [problem for problem in doctor.doctor()["problems"] if "torchvision" in problem]
    assert [("tactogram does without them" in problem) for problem in said] == [True] * (not compiled)
