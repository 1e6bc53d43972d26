"""Verbs that open the studio in the browser, and serve a study."""

from tactogram.cli.functions import FunctionVerb

VERBS = {
    "studio": FunctionVerb(
        "tactogram_studio.serving:studio", str, folders=("models", "designs", "languages")
    ),
    "study run": FunctionVerb("tactogram_studio.serving:run_study", str, folders=("designs", "languages")),
}
