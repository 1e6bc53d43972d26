"""The mutants still stand in the sources; `make mutants` holds the tests to them."""

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MUTANTS = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))["mutant"]


@pytest.mark.parametrize(
    "mutant", MUTANTS, ids=lambda mutant: f"{Path(mutant['file']).stem}: {mutant['title']}"
)
def test_a_mutant_applies_and_its_tests_are_there(mutant):
    source = (ROOT / mutant["file"]).read_text(encoding="utf-8")
    assert source.count(mutant["text"]) == 1, "change the mutant along with the source"
    changed = ast.parse(source.replace(mutant["text"], mutant["instead"]))
    assert ast.dump(changed) != ast.dump(ast.parse(source))
    for test in mutant["tests"]:
        file, _, name = test.partition("::")
        assert f"def {name or 'test_'}" in (ROOT / file).read_text(encoding="utf-8")
