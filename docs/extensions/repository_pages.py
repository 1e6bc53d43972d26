"""Pages that lie elsewhere in the repository: the models' READMEs and CONTRIBUTING; and links between all pages."""

import os
import re
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
README = ROOT / "README.md"
INCLUDING = DOCS / "models.md"
MODELS = ROOT / "src" / "tactogram" / "models"
PAGES = {ROOT / "CONTRIBUTING.md": "from-repository/contributing"} | {
    path: f"from-repository/{path.parent.name}" for path in sorted(MODELS.glob("*/README.md"))
}
"""Name of the page of each file."""
LINK = re.compile(r"\[([^\]]*)\]\((?![a-z]+:|[#/{])([^)#\s]+)(#[^)\s]*)?\)")


def relinked(text: str, place: Path, page: Path) -> str:
    """Return a text that lies at ``place`` with the links that it needs as ``page``: to pages, or else to files."""

    def replaced(link: re.Match[str]) -> str:
        target = Path(os.path.normpath(place.parent / link[2]))
        name = "five-minutes" if target == README else PAGES.get(target)
        path = os.path.relpath(DOCS / f"{name}.md" if name else target, page.parent)
        if name is None and target.suffix == ".md" and target.parent != DOCS:
            return f"{{download}}`{link[1]} <{path}>`"  # as any file that is no page
        return f"[{link[1]}]({path}{link[3] or ''})"

    return LINK.sub(replaced, text)


def write_pages(app: Sphinx) -> None:
    """Write ``from-repository/NAME.md``, each only if it changed."""
    for place, name in {**PAGES, README: "from-repository/readme"}.items():
        page = DOCS / f"{name}.md"
        # The README is no page: others include parts of it.
        text = relinked(place.read_text(encoding="utf-8"), place, INCLUDING if place == README else page)
        page.parent.mkdir(exist_ok=True)
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def relink_source(app: Sphinx, name: str, source: list[str]) -> None:
    """Let a page's links to what is a page here lead to that page."""
    place = Path(app.env.doc2path(name))
    if place.parent == DOCS and place.suffix == ".md":
        source[0] = relinked(source[0], place, place)


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx looks for documents."""
    app.connect("builder-inited", write_pages)
    app.connect("source-read", relink_source)
    return {"parallel_read_safe": True}
