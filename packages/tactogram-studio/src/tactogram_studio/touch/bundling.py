"""JavaScript of the page Touch as one module: for a saved page, and `tactogram.js` for pages of others."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from tactogram_study import participants

STATIC = Path(__file__).parents[1] / "static"
ROOTS = {
    "/static/": STATIC,
    "/participants/static/": Path(str(participants.__file__)).parent / "static",
}
"""Folders of addresses by their beginning."""
IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";$', re.MULTILINE)
EXPORTED = re.compile(r"^export (?=(?:async )?(?:class|function|const) (\w+))", re.MULTILINE)
EXPORTED_AGAIN = re.compile(r"^export \{([^}]*)\};$", re.MULTILINE)
WORKER = re.compile(r'new URL\("([^"]+)", import\.meta\.url\)')


def element_script() -> str:
    """Return `tactogram.js`: a module that defines ``<tactogram-pad>`` and is its own worklet."""
    head = f"/* tactogram.js {version('tactogram')}, Apache-2.0. Made from tactogram-studio: change its modules. */\n"
    return head + bundled(STATIC / "touch_element.js", own_worklet=True)


def bundled(entry: Path, roots: Mapping[str, Path] = ROOTS, *, own_worklet: bool = False) -> str:
    """Return a module and all that it imports as one module without imports.

    Each module becomes a function that returns what it exports. One whose address is made with ``import.meta.url``, of
    a worklet, becomes a data URL, since a page from a disk may not load a blob as a worklet. With ``own_worklet`` the
    result is loaded as the worklet, too, which a Content-Security-Policy of ``script-src 'self'`` allows, and exports
    what ``entry`` exports. Understands the form in which the studio's modules are written: named imports, and exports
    before a class, function or constant.
    """
    done: dict[Path, str] = {}

    def named(path: Path) -> str:
        return "$" + re.sub(r"\W", "_", path.stem)

    def found(address: str, module: Path) -> Path:
        for beginning, folder in roots.items():
            if address.startswith(beginning):
                return folder / address.removeprefix(beginning)
        return module.parent / address

    def body(module: Path) -> tuple[str, list[str]]:
        text = module.read_text(encoding="utf-8")
        exports = EXPORTED.findall(text)
        for names in EXPORTED_AGAIN.findall(text):
            exports += re.findall(r"\w+", names)

        def imported(match: re.Match[str]) -> str:
            path = found(match[2], module)
            add(path)
            return f"const {{{match[1].replace(' as ', ': ')}}} = {named(path)};"

        def inlined(match: re.Match[str]) -> str:
            if own_worklet:
                return "import.meta.url"
            source = json.dumps(bundled(found(match[1], module), roots))
            return f'"data:text/javascript," + encodeURIComponent({source})'

        text = IMPORT.sub(imported, text)
        text = EXPORTED_AGAIN.sub("", EXPORTED.sub("", text))
        return WORKER.sub(inlined, text), exports

    def add(module: Path) -> None:
        if module in done:
            return
        text, exports = body(module)
        done[module] = (
            f"const {named(module)} = (() => {{\n{text}\nreturn {{ {', '.join(exports)} }};\n}})();\n"
        )

    main, exports = body(entry)
    again = f"\nexport {{ {', '.join(exports)} }};\n" if own_worklet else ""
    return "".join(done.values()) + main + again
