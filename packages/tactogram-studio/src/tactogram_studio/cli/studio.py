"""Verbs that open the studio in the browser, serve a study, and write a texture for other pages."""

from typing import Any

from tactogram.cli.verbs import Verb


def _touch_text(result: dict[str, Any]) -> str:
    simulated = ", simulated" if result["simulated"] else ""
    return f"{result['file']}: {result['name']}{simulated}, {result['bytes']:,} bytes; follows {result['follows']}"


VERBS = {
    "studio": Verb("tactogram_studio.serving:studio", str, folders=("models", "designs", "languages")),
    "study run": Verb("tactogram_studio.serving:run_study", str, folders=("designs", "languages")),
    "touch": Verb(
        "tactogram_studio.touch.export:touch",
        _touch_text,
        notes=lambda result: result["notes"],
        folders=("models",),
    ),
}
