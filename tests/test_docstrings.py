"""Every public function of the documented interface says the shapes of its arrays and the errors it raises."""

import ast
import doctest
import inspect
import re
from pathlib import Path

import pytest

import tactogram
import tactogram_playback

ROOT = Path(__file__).parents[1]
FUNCTIONS = {name: getattr(tactogram, name) for name in tactogram.__all__} | {
    "stream": tactogram_playback.stream
}
PUBLIC = {function.__module__ for function in FUNCTIONS.values()}
MODULES = (
    "tactogram.model.conditions",
    "tactogram.model.examples",
    "tactogram.model.kinds",
    "tactogram.model.model",
    "tactogram.model.batch_share",
    "tactogram.datasets.recording",
    "tactogram.datasets.store.writing",
    "tactogram.datasets.store.writing",
    "tactogram.datasets.ratings.ratings",
    "tactogram.datasets.ratings.table",
    "tactogram.statistics.comparison",
    "tactogram.statistics.reliability",
    "tactogram.datasets.splits.split",
    "tactogram.datasets.splits.splitting",
    "tactogram.datasets.splits.photograph_splitting",
    "tactogram.signal.displacement",
    "tactogram.rendering.displays.display",
    "tactogram.rendering.level",
    "tactogram.rendering.drive.fit",
    "tactogram.rendering.drive.report",
    "tactogram.rendering.drive.safety",
    "tactogram.recipe",
    "tactogram.features.spectrogram",
    "tactogram.features.spectrogram_picture",
    "tactogram.features.photo_pairs",
    "tactogram.evaluation.pictures.distances",
    "tactogram.signal.autoregressive",
    "tactogram_playback.drive_guard",
)
"""Others that promise it, too: what importers, displays and models are written with."""
ARRAY = re.compile(r"NDArray|ArrayLike|Tensor")
SHAPE = re.compile(r"shape|->|\bany length\b")
ELSEWHERE = re.compile(r"\b(as|see) (of )?`|\berrors as\b", re.IGNORECASE)
"""Said once, where it says."""


def source(module):
    package = module.partition(".")[0]
    folder = ROOT if package == "tactogram" else ROOT / "packages" / package.replace("_", "-")
    path = folder / "src" / module.replace(".", "/")
    return (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8")


def functions(nodes, prefix=""):
    """Yield name and node of every public function, and of the public methods of public classes."""
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            if isinstance(node, ast.ClassDef):
                yield from functions(node.body, f"{prefix}{node.name}.")
            else:
                yield prefix + node.name, node


def raised(node):
    """Return the names of the errors that a function raises itself, not those of functions within it."""
    found = set()
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Raise) and child.exc is not None:
            error = child.exc.func if isinstance(child.exc, ast.Call) else child.exc
            found |= {error.id} if isinstance(error, ast.Name) and error.id.endswith("Error") else set()
        if not isinstance(child, ast.FunctionDef | ast.Lambda):
            found |= raised(child)
    return found - {"ValueError"}  # within what turns it into an error of ours


def lacks(node):
    """Return what the docstring of a function does not say."""
    said = ast.get_docstring(node) or ""
    if not said:
        return ["a docstring"]
    held = [*node.args.args, *node.args.kwonlyargs]
    types = [ast.unparse(kind) for kind in (*(a.annotation for a in held), node.returns) if kind is not None]
    missing = [error for error in sorted(raised(node)) if error not in said and not ELSEWHERE.search(said)]
    arrays = any(ARRAY.search(kind) for kind in types)
    return missing + (["a shape"] if arrays and not SHAPE.search(said) and not ELSEWHERE.search(said) else [])


@pytest.mark.parametrize("module", sorted({*PUBLIC, *MODULES}))
def test_shapes_and_errors_are_said(module):
    tree = ast.parse(source(module))
    found = {name: missing for name, node in functions(tree.body) if (missing := lacks(node))}
    assert not found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_examples_give_what_they_say(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    public = inspect.unwrap(FUNCTIONS[name])
    runner = doctest.DocTestRunner()
    names = {"tactogram": tactogram, "tactogram_playback": tactogram_playback}
    examples = doctest.DocTestFinder(recurse=False).find(public, name, globs=names)
    assert any(each.examples for each in examples), "give an example"
    assert all(runner.run(example).failed == 0 for example in examples)


def test_what_is_not_said_is_found():
    tree = ast.parse(
        'def one(x: ArrayLike) -> int:\n    """Return it."""\n    if x:\n        raise DataError(x)\n'
        'def two(x: ArrayLike) -> int:\n    """Refuse x, shape (time,): `DataError`."""\n    raise DataError(x)\n'
        "def three() -> int:\n    return 3\n"
    )
    found = {name: lacks(node) for name, node in functions(tree.body)}
    assert found == {"one": ["DataError", "a shape"], "two": [], "three": ["a docstring"]}


def test_headings_of_modules_and_classes_name_a_thing():
    question = re.compile(r"(What|How|Whether|Where|Which|When|Who|Why|Of|From)\b")
    found = []
    for path in sorted((*ROOT.glob("src/**/*.py"), *ROOT.glob("packages/*/src/**/*.py"))):
        if "tests" not in path.parts:
            tree = ast.parse(path.read_text(encoding="utf-8"))
            nodes = [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]
            heads = [(ast.get_docstring(node) or "").partition("\n")[0] for node in nodes]
            found += [f"{path.name}: {head}" for head in heads if question.match(head)]
    assert not found
