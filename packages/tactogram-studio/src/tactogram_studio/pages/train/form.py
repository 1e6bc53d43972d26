"""Training form: model, data, recipe with its settings, and split."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any
from urllib.parse import quote

from nicegui import app, ui

from tactogram.datasets import open_store
from tactogram.errors import ParameterError
from tactogram.model import condition_types
from tactogram.models import ModelInfo, available
from tactogram.recipe import parse_changes
from tactogram.workflows import (
    RecipeField,
    TrainingRequest,
    assignments,
    model_choice,
    recipe_fields,
    text_of,
)
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.tasks.queue import output_name, trainings_of
from tactogram_studio.workspace.commands import arguments, command_line, free_name

PURPOSES = {
    "recognition": "Recognise materials",
    "generate": "Generate materials by name",
    "photograph": "Generate from photographs",
    "words": "Generate from words",
    "rating": "Predict ratings in words",
}
"""What a model is trained for, as `tactogram.workflows.model_choice` takes it."""
SPLITS = {
    "": "random validation and test parts",
    "last": "last recordings of each material as test part",
    "blocks": "last fifth of every recording as test part",
    "all": "no test part",
}
SPLIT_TEXTS = {
    "": "Of each material, a fifth of the recordings is used for testing and a tenth for validation. This needs at "
    "least three recordings of each; with fewer, choose another split.",
    "last": "The last recordings of each material are used for testing and, where there are enough, the one before "
    "them for validation.",
    "blocks": "Every recording is divided: its last fifth is used for testing, one window after the rest. This is for "
    "single long recordings of each material; it says nothing about another recording of it.",
    "all": "All recordings are used for training: the run cannot be evaluated on its own data.",
}
"""Explanation of each split."""
GROUPINGS = {
    "recording": "single recordings",
    "session": "recordings of a session",
    "subject": "recordings of a subject",
    "material": "recordings of a material (tests unseen materials)",
    "condition": "recordings of a condition (speed and force)",
}
"""Groups of recordings that a split never divides."""
SETTINGS = "Recipe settings"


def training_options(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a training that the form has, from its entries: those of `tactogram.workflows.train`.

    Raises `ParameterError` if the filter is not ``KEY=VALUE``, separated by spaces.
    """
    conditions = {}
    for text in (values["where"] or "").split():
        key, sign, value = text.partition("=")
        if not (sign and key and value):
            raise ParameterError(f"the filter must be KEY=VALUE, got {text!r}")
        conditions[key] = value
    return {
        "recipe": values["recipe"],
        "split": f"last={int(values['last'] or 1)}" if values["split"] == "last" else values["split"],
        "by": values["by"],
        "label": (values["label"] or "material").strip(),
        "where": conditions,
        "changes": parse_changes(values.get("set") or ()),
    }


def training_arguments(values: Mapping[str, Any]) -> list[str]:
    """Return the equivalent arguments of ``tactogram``; `ParameterError` if an entry is not valid."""
    chosen = training_options(values)
    chosen |= {
        "where": [f"{key}={value}" for key, value in chosen["where"].items()],
        "changes": values.get("set"),
    }
    options = {name: value for name, value in chosen.items() if value not in ("recording", "material")}
    return arguments(
        "train", values["model"], data=values["data"], **options, out=output_name("runs", values["name"])
    )


def describe_model(model: ModelInfo) -> str:
    """Return what a model does, what it learns from, and its paper."""
    tasks = "; or ".join(_described(face) for face in model.faces)
    authors = model.authors[0] + (" et al." if len(model.authors) > 1 else "")
    return f"{tasks[0].upper()}{tasks[1:]}. {authors} {model.year}: {model.title}."


def _described(model: ModelInfo) -> str:
    task = {
        "classification": "classifies the material of a signal",
        "generation": f"generates {'an image' if model.gives == 'image' else 'signals'}",
        "prediction": "predicts word ratings of signals or images",
    }[model.task]
    options = {name: one.options[0].name for name, one in condition_types().items() if one.options}
    inputs = [options[name] for name in model.needs]
    inputs += [
        f"{options[name]} (optional)" for name in model.takes if name in options and "vibration_" not in name
    ]
    source = f" from {_listed(inputs)}" if inputs and model.task == "generation" else ""
    data = {
        "recordings": "recordings of materials" + (" with photographs" if "image" in model.needs else ""),
        "ratings": "people's ratings of signals or images",
        "images": "rated images",
        "both": "rated surfaces and rated signals",
    }[model.learns_from]
    return f"{task}{source}; learns from {data}"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]


def draw(studio: Studio, *, purpose: str = "", model: str = "", data: str = "", key: str = "") -> None:
    """Draw the form, which survives a reload; ``purpose``, ``model``, ``data`` preselect, ``key`` is the tab's."""
    stores = [studio.workspace.name_of(path) for path in studio.workspace.stores()]
    if not stores:
        ui.label("There is no store in this workspace yet.")
        ui.link("Simulate or import one", "/materials")
        return
    values = kit.TabSettings(app.storage.user.setdefault("train", {}), key)
    kit.keep_address("/train", key=values.key)
    values.setdefault("changes", {})
    if data in stores:
        values["data"] = data
    models = available()
    if purpose in PURPOSES:
        values["purpose"] = purpose
    if model in models:
        values.update({"purpose": purpose_of(models[model]), "model": model})
    form = _TrainingForm(studio, models, stores, values)
    form.recommend(choose=model not in models)


def purpose_of(model: ModelInfo) -> str:
    """Return what a model is trained for: one of `PURPOSES`."""
    if model.task != "generation":
        return "recognition" if model.task == "classification" else "rating"
    return {"image": "photograph", "words": "words"}.get(next(iter(model.needs), ""), "generate")


class _TrainingForm:
    """Fields of a training, whose entries are in ``values``."""

    def __init__(
        self, studio: Studio, models: dict[str, ModelInfo], stores: list[str], values: kit.TabSettings
    ) -> None:
        self.studio, self.models, self.values = studio, models, values
        if values.get("model") not in models:
            values["model"], values["recommended"] = next(iter(models)), None
        self.settings: list[RecipeField] = []
        fields = kit.Form(values, self._changed)
        with kit.column(gap=2):
            fields.choice("purpose", PURPOSES, "Purpose", "generate").on_value_change(self.recommend)
            fields.choice("data", stores, "Store").on_value_change(self.recommend)
            self.recommended = kit.hint("")
            self.name = fields.text("name", "Run name")
            self.error = kit.alert()
            self.start = ui.button("Start", on_click=self._start).classes("w-full")
            with ui.expansion("More options").classes("w-full") as self.more:
                self._draw_more(fields)
            kit.hint("Equivalent command")
            self.command = kit.code()
        self._show_model()
        self._changed()  # restored values do not trigger a change

    def _draw_more(self, fields: kit.Form) -> None:
        with kit.column(gap=2):
            self.model_choice = fields.choice("model", list(self.models), "Model")
            self.model_choice.on_value_change(self._choose_model)
            self.description = kit.hint("")
            self.recipe = ui.select([], label="Recipe", on_change=self._choose_recipe)
            self.recipe_text = kit.hint("")
            split = fields.choice("split", SPLITS, "Split", "")
            kit.hint("").bind_text_from(split, "value", SPLIT_TEXTS.__getitem__)
            last = fields.number("last", "Test recordings of each material", 2)
            last.bind_visibility_from(split, "value", value="last")
            fields.choice("by", GROUPINGS, "Keep together", "recording")
            label = fields.text("label", "Class", "material", placeholder="material")
            label.tooltip("Fields that define a class, such as material+contactor")
            fields.text("where", "Filter recordings", placeholder="contactor=finger")
            self.settings_button = ui.button(SETTINGS, on_click=self._open_settings).props("outline")
        self.dialog = ui.dialog().props(f'full-width aria-label="{SETTINGS}"')

    @property
    def model(self) -> ModelInfo:
        return self.models[self.values["model"]]

    def recommend(self, *, choose: bool = True) -> None:
        """Recommend a model and a recipe for the purpose, or say why the store is not for it.

        They are chosen if they are not those recommended before, unless ``choose`` is false.
        """
        self.recommended.text = ""
        with kit.refusals(self.error):
            store = open_store(self.studio.workspace.inside(self.values["data"]))
            items = self.values["label"] == "item"
            purpose = self.values["purpose"]
            model, recipe, reason = model_choice(purpose, store, label="item" if items else "material")
            if choose and self.values.get("recommended") != [model, recipe]:
                if model != self.values["model"]:
                    self.values["recipe"] = recipe
                self.model_choice.value, self.recipe.value = model, recipe
            self.values["recommended"] = [model, recipe]
            other = "" if self.values["model"] == model else f" Chosen below: {self.values['model']}."
            self.recommended.text = f"Recommended: {model}, {reason}.{other}"

    def _show_model(self) -> None:
        self.description.text = describe_model(self.model)
        recipes = list(self.model.recipes())
        if self.values.get("recipe") not in recipes:
            self.values["recipe"] = "quick" if "quick" in recipes else recipes[0]
        self.recipe.set_options(recipes, value=self.values["recipe"])
        self._show_recipe()

    def _show_recipe(self) -> None:
        lines = self.model.recipe(self.values["recipe"]).read_text(encoding="utf-8").split("\n")
        self.recipe_text.text = " ".join(line.lstrip("# ") for line in lines if line.startswith("#"))
        runs = self.studio.workspace.folder / "runs"
        self.name.value = free_name(runs, f"{self.values['model']}-{self.values['recipe']}")
        self.settings = []

    def _discard_changes(self) -> None:
        self.values["changes"], self.values["set"] = {}, []

    def _choose_model(self) -> None:
        self._discard_changes()
        self._show_model()
        self._changed()
        self.recommend(choose=False)

    def _choose_recipe(self, event: Any) -> None:
        if event.value and event.value != self.values["recipe"]:
            self.values["recipe"] = event.value
            self._discard_changes()
            self._show_recipe()
            self._changed()

    async def _open_settings(self) -> None:
        if not self.settings:
            with kit.busy("Reading the model's settings", button=self.settings_button):
                self.settings = await kit.in_background(recipe_fields, self.model, self.values["recipe"])
            self.dialog.clear()
            with self.dialog, ui.card().classes("w-full"):
                kit.heading(f"Settings of {self.values['model']}, recipe {self.values['recipe']}")
                with ui.element("div").classes("tiles w-full"):
                    for field in self.settings:
                        self._draw_setting(field)
                ui.button("Done", on_click=self.dialog.close)
        self.dialog.open()

    def _draw_setting(self, field: RecipeField) -> None:
        default = text_of(field.value) if field.widget == "text" else field.value

        def change(entry: Any) -> None:
            self.values["changes"] = {**self.values["changes"], field.key: entry}
            self._changed()

        with kit.column(gap=0):
            label = field.key.removeprefix("config.")
            kit.declared_field(field, label, self.values["changes"].get(field.key, default), change)
            text = field.text.replace("`", "")
            if field.published != field.value:
                origin = "Published" if field.key.startswith("config.") else "Default"
                text = f"{origin}: {text_of(field.published) or 'none'}. {text}"
            kit.hint(text)

    def _changed(self) -> None:
        """Show the command, or what is wrong with the form."""
        with kit.refusals(self.error):
            if self.settings:
                self.values["set"] = assignments(self.settings, self.values["changes"])
            elif not self.values["changes"]:
                self.values["set"] = []
            self.command.text = command_line(training_arguments(self.values))
        count = len(self.values.get("set") or [])
        self.settings_button.text = SETTINGS + (f" ({count} changed)" if count else "")

    async def _start(self) -> None:
        with (
            kit.refusals(self.error, partial(kit.in_fields, labels={"split": "Split"}, titles=SPLITS)),
            kit.busy("Checking model and data", button=self.start),
        ):
            from tactogram.workflows import check_training  # brings torch

            queue, folder = trainings_of(self.studio.workspace), output_name("runs", self.values["name"])
            words = training_arguments(self.values)
            queue.new_output(folder)
            data = self.studio.workspace.inside(self.values["data"])
            training = TrainingRequest(self.values["model"], data, **training_options(self.values))
            await kit.in_background(check_training, training)
            await kit.in_background(queue.begin_new, "train", words, folder)
            self._discard_changes()
            ui.navigate.to(f"/train/watch?run={quote(folder)}")
