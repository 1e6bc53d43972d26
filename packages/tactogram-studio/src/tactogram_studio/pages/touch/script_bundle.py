"""One script of the studio's modules, for a page without a server.

Browsers load no modules from beside a file that is opened from a disk.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";$', re.MULTILINE)
EXPORTED = re.compile(r"^export (?=(?:async )?(?:class|function|const) (\w+))", re.MULTILINE)
EXPORTED_AGAIN = re.compile(r"^export \{([^}]*)\};$", re.MULTILINE)
WORKER = re.compile(r'new URL\("([^"]+)", import\.meta\.url\)')


def bundled(entry: Path, roots: Mapping[str, Path]) -> str:
    """Return a module and all that it imports as one module without imports.

    ``roots`` are the folders of addresses by their beginning, e.g. ``{"/static/": FOLDER}``. Each module becomes a
    function that returns what it exports; one whose address is made with ``import.meta.url``, of a worklet, becomes a
    data URL, since a page from a disk may not load a blob as a worklet. Understands the form in which the studio's
    modules are written: named imports, and exports before a class, function or constant.
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

    main, _ = body(entry)
    return "".join(done.values()) + main
