"""Training form: model, data, recipe with its settings, and split."""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

from nicegui import app, ui

from tactogram.datasets import open_store
from tactogram.models import ModelInfo, available
from tactogram.workflows import RecipeField, assignments, model_choice, recipe_fields, text_of
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.train.request import GROUPINGS, SPLIT_TEXTS, SPLITS, RunRequest, describe_model
from tactogram_studio.tasks.queue import trainings_of
from tactogram_studio.workspace.commands import command_line, free_name

SETTINGS = "Recipe settings"


def draw(studio: Studio, *, model: str = "", data: str = "") -> None:
    """Draw the form, which survives a reload; ``model`` and ``data`` preselect."""
    stores = [studio.workspace.name_of(path) for path in studio.workspace.stores()]
    if not stores:
        ui.label("There is no store in this workspace yet.")
        ui.link("Simulate or import one", "/materials")
        return
    values: dict[str, Any] = app.storage.user.setdefault("train", {})
    values.setdefault("changes", {})
    if data in stores or values.get("data") not in stores:
        values["data"] = data if data in stores else stores[0]
    models = available()
    if model in models:
        values["model"] = model
    if values.get("model") not in models:
        store = open_store(studio.workspace.inside(values["data"]))
        values["model"], values["recipe"], _ = model_choice("generate", store)
    _TrainingForm(studio, models, stores, values)


class _TrainingForm:
    """Fields of a training, whose entries are in ``values``."""

    def __init__(
        self, studio: Studio, models: dict[str, ModelInfo], stores: list[str], values: dict[str, Any]
    ) -> None:
        self.studio, self.models, self.values = studio, models, values
        self.settings: list[RecipeField] = []
        fields = kit.Form(values, self._changed)
        with kit.column(gap=2):
            model = fields.choice("model", list(models), "Model").props("options-dense")
            model.on_value_change(self._choose_model)
            self.description = kit.hint("")
            fields.choice("data", stores, "Store")
            self.recipe = ui.select([], label="Recipe", on_change=self._choose_recipe)
            self.recipe_text = kit.hint("")
            split = fields.choice("split", SPLITS, "Split", "")
            kit.hint("").bind_text_from(split, "value", SPLIT_TEXTS.__getitem__)
            last = fields.number("last", "Test recordings of each material", 2)
            last.bind_visibility_from(split, "value", value="last")
            with ui.expansion("Data options").classes("w-full").props("dense"):
                fields.choice("by", GROUPINGS, "Keep together", "recording")
                label = fields.text("label", "Class", "material", placeholder="material")
                label.tooltip("Fields that define a class, such as material+contactor")
                fields.text("where", "Filter recordings", placeholder="contactor=finger")
            self.settings_button = ui.button(SETTINGS, on_click=self._open_settings).props("outline")
            self.dialog = ui.dialog().props(f'full-width aria-label="{SETTINGS}"')
            self.name = fields.text("name", "Run name")
            kit.hint("Equivalent command")
            self.command, self.error = kit.code(), kit.alert()
            self.start = ui.button("Start", on_click=self._start).classes("w-full")
        self._show_model()
        self._changed()  # restored values do not trigger a change

    @property
    def model(self) -> ModelInfo:
        return self.models[self.values["model"]]

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
        given = text_of(field.value) if field.widget == "text" else field.value

        def change(entry: Any) -> None:
            self.values["changes"] = {**self.values["changes"], field.key: entry}
            self._changed()

        with kit.column(gap=0):
            label = field.key.removeprefix("config.")
            kit.declared_field(field, label, self.values["changes"].get(field.key, given), change)
            text = field.text.replace("``", "")
            if field.published != field.value:
                origin = "Published" if field.key.startswith("config.") else "Default"
                text = f"{origin}: {text_of(field.published) or 'none'}. {text}"
            kit.hint(text)

    def _request(self) -> RunRequest:
        v = self.values
        if self.settings:
            v["set"] = assignments(self.settings, v["changes"])
        elif not v["changes"]:
            v["set"] = []
        return RunRequest(
            v["model"],
            v["data"],
            v["recipe"],
            (v["name"] or "").strip(),
            v["split"],
            int(v["last"] or 1),
            v["by"],
            (v["label"] or "material").strip(),
            v["where"] or "",
            tuple(v.get("set", ())),
        )

    def _changed(self) -> None:
        """Show the command, or what is wrong with the form."""
        with kit.refusals(self.error):
            kit.set_text(self.command, command_line(self._request().arguments))
        count = len(self.values.get("set") or [])
        self.settings_button.text = SETTINGS + (f" ({count} changed)" if count else "")

    async def _start(self) -> None:
        request, workspace = self._request(), self.studio.workspace
        with kit.refusals(self.error), kit.busy("Checking model and data", button=self.start):
            from tactogram.workflows import check_training  # brings torch

            queue = trainings_of(workspace)
            queue.new_output(request.folder)
            training = request.training_request(workspace.inside(request.data))
            await kit.in_background(check_training, training)
            await kit.in_background(queue.begin_new, "train", request.arguments, request.folder)
            self._discard_changes()
            ui.navigate.to(f"/train/watch?run={quote(request.folder)}")
