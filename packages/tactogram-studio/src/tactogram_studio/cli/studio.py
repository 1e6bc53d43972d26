"""Verbs that open the studio in the browser, and serve a study."""

from tactogram.cli.verbs import Verb

VERBS = {
    "studio": Verb("tactogram_studio.serving:studio", str, folders=("models", "designs", "languages")),
    "study run": Verb("tactogram_studio.serving:run_study", str, folders=("designs", "languages")),
}
