"""Modules become one file; that of `packages/tactogram-js` is the studio's."""

import json
from importlib.metadata import version
from pathlib import Path

from tactogram_studio.touch.bundling import bundled, element_script

PACKAGE = Path(__file__).parents[3] / "tactogram-js"


def test_modules_become_one(tmp_path):
    (tmp_path / "main.js").write_text(
        'import { twice as doubled } from "./twice.js";\nimport { ONE } from "/static/one.js";\nlog(doubled(ONE));\n'
    )
    (tmp_path / "twice.js").write_text(
        'import { ONE } from "./one.js";\n\nexport function twice(x) {\n  return 2 * ONE * x;\n}\n'
    )
    (tmp_path / "one.js").write_text("export const ONE = 1;\n")
    text = bundled(tmp_path / "main.js", {"/static/": tmp_path})
    assert text.index("$one = ") < text.index("$twice = ") < text.index("log(")
    assert text.count("ONE = 1") == 1
    assert "import {" not in text
    assert "export" not in text
    assert "const { twice: doubled } = $twice;" in text


def test_a_module_that_is_its_own_worklet_keeps_its_exports(tmp_path):
    (tmp_path / "main.js").write_text(
        'import {} from "./worklet.js";\nexport const start = (audio) =>\n'
        '  audio.addModule(new URL("worklet.js", import.meta.url));\n'
    )
    (tmp_path / "worklet.js").write_text("globalThis.registerProcessor?.();\n")
    text = bundled(tmp_path / "main.js", {}, own_worklet=True)
    assert "audio.addModule(import.meta.url)" in text
    assert text.endswith("export { start };\n")
    assert "data:" not in text


def test_the_file_for_other_pages_is_made_from_the_studios_modules(request):
    path = PACKAGE / "tactogram.js"
    if request.config.getoption("--regen"):
        path.write_text(element_script(), encoding="utf-8")
    assert path.read_text(encoding="utf-8") == element_script(), "make it anew: pytest --regen"


def test_the_packages_facts_are_those_of_the_project():
    package = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
    assert package["version"] == version("tactogram-studio")
    assert package["license"] == "Apache-2.0"
    named = {package["main"], package["types"], *package["files"]}
    assert all((PACKAGE / name).is_file() for name in named)
