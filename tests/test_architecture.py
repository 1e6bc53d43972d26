"""What holds for the project as a whole."""

import ast
import importlib.metadata
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

import tactogram

ROOT = Path(__file__).parents[1]
LIGHT = [
    "tactogram.signal",
    "tactogram.signal.io",
    "tactogram.model",
    "tactogram.recipe",
    "tactogram.datasets",
    "tactogram.statistics",
    "tactogram.rendering",
    "tactogram.cli",
    "tactogram.models",
    "tactogram_capture.catalogue",
    "tactogram_playback.workflows.actuators",
    "tactogram_playback.workflows.playback",
    "tactogram_playback.workflows.stream",
    "tactogram_simulate.sets",
    "tactogram_study.study_file",
]


def test_these_need_no_torch():
    code = (
        "import sys\nfrom importlib import import_module\n"
        f"for name in {LIGHT}: import_module(name); assert 'torch' not in sys.modules, name"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_models_are_listed_without_the_libraries_that_train_them():
    code = "import sys, tactogram.models as m; m.available(); sys.exit(bool({'torch', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_study_designs_are_listed_without_the_libraries_that_analyse_them():
    heavy = {"scipy", "statsmodels", "matplotlib", "torch", "pyarrow"}
    code = (
        f"import sys, tactogram_study.designs as d; d.designs(); sys.exit(bool({heavy} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_imports_point_one_way():
    command = [str(Path(sys.executable).with_name("lint-imports"))]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


APPLICATIONS = sorted((ROOT / "packages").glob("*/src/*"))


@pytest.mark.parametrize("folder", APPLICATIONS, ids=lambda folder: folder.name)
def test_an_application_imports_of_the_core_what_its_packages_list(folder):
    inner = set()
    for module in _modules_imported(folder):
        place = ROOT / "src" / module.replace(".", "/")
        public = module.count(".") == 1 or (place / "__init__.py").is_file()
        inner |= {module} if module.startswith("tactogram.") and not public else set()
    declaring = {"tactogram.cli.verbs", "tactogram.cli.printing"}
    assert inner <= declaring  # what verbs are declared with


@pytest.mark.parametrize("folder", APPLICATIONS, ids=lambda folder: folder.name)
def test_an_application_imports_of_the_simulator_what_it_lists(folder):
    inner = {module for module in _modules_imported(folder) if module.startswith("tactogram_simulate.")}
    assert folder.name == "tactogram_simulate" or not inner


def _modules_imported(folder):
    trees = (ast.parse(file.read_text(encoding="utf-8")) for file in folder.rglob("*.py"))
    nodes = (node for tree in trees for node in ast.walk(tree))
    return {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module}


def test_no_modules_import_each_other_in_a_circle():
    """Whatever form an import has: at the top, in a function, for type checkers, or by a module's name in a text."""
    folders = (ROOT / "src" / "tactogram", *APPLICATIONS)
    files = {_module_name(path, folder): path for folder in folders for path in folder.rglob("*.py")}
    imported = [_imports(path, files.keys()) for path in files.values()]
    matrix = np.array([[name in others for name in files] for others in imported])
    _, circle = connected_components(matrix, connection="strong")
    found = [{name for name, each in zip(files, circle, strict=True) if each == one} for one in set(circle)]
    closed = [each for each in found if len(each) > 1]
    assert closed == []


def _module_name(path, folder):
    parts = path.relative_to(folder.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(path, modules):
    """Return the modules, without ``tactogram.``, that a file imports; of a package what it takes from there."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {
                name if (name := f"{node.module}.{each.name}") in modules else node.module
                for each in node.names
            }
        elif isinstance(node, ast.Import):
            found |= {each.name for each in node.names}
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "import_module":
            found |= {each.value for each in node.args if isinstance(each, ast.Constant)}
    return found & set(modules)


def test_the_public_interface_is_what_type_checkers_see():
    module = ast.parse((ROOT / "src" / "tactogram" / "__init__.py").read_text())
    checked = next(part for part in module.body if isinstance(part, ast.If)).body
    assert {alias.asname: part.module for part in checked for alias in part.names} == tactogram._PLACES
    for name in tactogram.__all__:
        assert getattr(tactogram, name).__name__ == name
    assert tactogram.__version__ == importlib.metadata.version("tactogram")
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = tactogram.nothing


def test_every_dependency_is_pinned_and_has_its_reason():
    files = (ROOT / "pyproject.toml", *sorted(ROOT.glob("packages/*/pyproject.toml")))
    projects = [tomllib.loads(file.read_text())["project"] for file in files]
    assert len(projects) == 7
    pinned = {
        line.split("==")[0].lower()
        for line in (ROOT / "constraints.txt").read_text().splitlines()
        if "==" in line
    }
    needed = [
        text
        for project in projects
        for texts in (project["dependencies"], *project.get("optional-dependencies", {}).values())
        for text in texts
    ]
    names = {re.split("[\\[>=]", text)[0].lower() for text in needed}
    own = {project["name"]: f"=={project['version']}" for project in projects}
    assert {name for name in names if name not in own} <= pinned
    for text in needed:  # distributions of the project go together
        assert own.get(text.partition("==")[0], "") in text
