"""Training form: model, data, recipe with its settings, and split."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import app, ui

from tactogram.datasets import open_store
from tactogram.errors import ParameterError, TactogramError
from tactogram.models import ModelInfo, available
from tactogram.workflows import RecipeField, assignments, model_choice, recipe_fields, text_of
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.train.request import GROUPINGS, SPLIT_TEXTS, SPLITS, RunRequest, describe_model
from tactogram_studio.pages.train.trainings import command_line, free_name
from tactogram_studio.pages.train.widgets import TrainContext

DEFAULTS = {"split": "", "last": 2, "by": "recording", "label": "material", "where": "", "name": ""}
SETTINGS = "Recipe settings"


def draw(context: TrainContext, *, model: str = "", data: str = "") -> None:
    """Draw the form, which survives a reload; ``model`` and ``data`` preselect."""
    workspace = context.studio.workspace
    models = available()
    stores = [workspace.name_of(path) for path in workspace.stores()]
    values: dict[str, Any] = app.storage.user.setdefault("train", {})
    for name, default in DEFAULTS.items():
        values.setdefault(name, default)
    values.setdefault("changes", {})
    values["data"] = data if data in stores else _valid(values.get("data"), stores, next(iter(stores), None))
    heading("Start a training")
    if not stores:
        ui.label("There is no store in this workspace yet.")
        ui.link("Simulate or import one", "/materials")
        return
    values["model"] = model if model in models else _valid(values.get("model"), models, "")
    if not values["model"]:
        chosen = model_choice("generate", open_store(workspace.inside(values["data"])))
        values["model"], values["recipe"], _ = chosen
    _TrainingForm(context, models, stores, values).draw()


def _valid(value: Any, options: Collection[str], default: Any) -> Any:
    return value if value in options else default


class _TrainingForm:
    """Widgets bound to stored values."""

    def __init__(
        self, context: TrainContext, models: dict[str, ModelInfo], stores: list[str], values: dict[str, Any]
    ) -> None:
        self.context, self.models, self.stores, self.values = context, models, stores, values
        self.fields: list[RecipeField] = []

    @property
    def model(self) -> ModelInfo:
        return self.models[self.values["model"]]

    def draw(self) -> None:
        values, changed = self.values, self._changed
        with ui.column().classes("w-full gap-2 items-stretch"):
            model = ui.select(list(self.models), label="Model", value=values["model"])
            model.props("options-dense").on_value_change(self._choose_model)
            self.description = hint("")
            ui.select(self.stores, label="Store", value=values["data"], on_change=self._choose_data)
            self.recipe = ui.select([], label="Recipe", on_change=self._choose_recipe)
            self.recipe_text = hint("")
            split = ui.select(SPLITS, label="Split").bind_value(values, "split").on_value_change(changed)
            hint("").bind_text_from(values, "split", SPLIT_TEXTS.__getitem__)
            last = ui.number("Test recordings of each material", min=1, precision=0)
            last.bind_value(values, "last").on_value_change(changed)
            last.bind_visibility_from(split, "value", value="last")
            with ui.expansion("Data options").classes("w-full").props("dense"):
                ui.select(GROUPINGS, label="Keep together").bind_value(values, "by").on_value_change(changed)
                label = ui.input("Class", placeholder="material").bind_value(values, "label")
                label.on_value_change(changed).tooltip(
                    "Fields that define a class, such as material+contactor"
                )
                where = ui.input("Filter recordings", placeholder="contactor=finger")
                where.bind_value(values, "where").on_value_change(changed)
            self.settings_button = ui.button(SETTINGS, on_click=report_errors(self._open_settings))
            self.settings_button.props("outline")
            self.dialog = ui.dialog().props(f'full-width aria-label="{SETTINGS}"')
            self.name = ui.input("Run name").bind_value(values, "name").on_value_change(changed)
            hint("Equivalent command")
            self.command = ui.element("code").classes("small")
            self.command.style("overflow-wrap: anywhere; display: block")
            self.error = ui.label().classes("text-negative").props('role="alert"')
            self.start = ui.button("Start", on_click=report_errors(self._start)).classes("w-full")
        self._show_model()
        self._changed()  # restored values do not trigger a change

    def _show_model(self) -> None:
        self.description.text = describe_model(self.model)
        recipes = list(self.model.recipes())
        default = "quick" if "quick" in recipes else recipes[0]
        self.values["recipe"] = _valid(self.values.get("recipe"), recipes, default)
        self.recipe.set_options(recipes, value=self.values["recipe"])
        self._show_recipe()

    def _show_recipe(self) -> None:
        lines = self.model.recipe(self.values["recipe"]).read_text(encoding="utf-8").split("\n")
        self.recipe_text.text = " ".join(line.lstrip("# ") for line in lines if line.startswith("#"))
        runs = self.context.studio.workspace.folder / "runs"
        self.name.value = free_name(runs, f"{self.values['model']}-{self.values['recipe']}")
        self.fields = []
        self._count_changes()

    def _discard_changes(self) -> None:
        self.values["changes"], self.values["set"] = {}, []

    def _choose_model(self, event: Any) -> None:
        self.values["model"] = event.value
        self._discard_changes()
        self._show_model()
        self._changed()

    def _choose_data(self, event: Any) -> None:
        self.values["data"] = event.value
        self._changed()

    def _choose_recipe(self, event: Any) -> None:
        if event.value and event.value != self.values["recipe"]:
            self.values["recipe"] = event.value
            self._discard_changes()
            self._show_recipe()
            self._changed()

    def _count_changes(self) -> None:
        count = len(self.values.get("set") or [])
        self.settings_button.text = SETTINGS + (f" ({count} changed)" if count else "")

    async def _open_settings(self) -> None:
        if not self.fields:
            with busy("Reading the model's settings", button=self.settings_button):
                self.fields = await in_background(recipe_fields, self.model, self.values["recipe"])
            self.dialog.clear()
            with self.dialog, ui.card().classes("w-full"):
                heading(f"Settings of {self.values['model']}, recipe {self.values['recipe']}")
                with ui.element("div").classes("tiles w-full"):
                    for field in self.fields:
                        self._draw_field(field)
                ui.button("Done", on_click=self.dialog.close)
        self.dialog.open()

    def _draw_field(self, field: RecipeField) -> None:
        entry = self.values["changes"].get(field.key)
        value = field.value if entry is None else entry

        def change(event: Any) -> None:
            self.values["changes"] = {**self.values["changes"], field.key: event.value}
            self._changed()

        with ui.column().classes("w-full gap-0 items-stretch"):
            label = field.key.removeprefix("config.")
            if field.widget == "switch":
                ui.switch(label, value=bool(value), on_change=change)
            elif field.widget == "choice":
                ui.select(list(field.choices), label=label, value=value, on_change=change).props("dense")
            elif field.widget in ("integer", "number"):
                ui.number(label, value=value, on_change=change, format="%.6g").props("dense")
            else:
                text = entry if isinstance(entry, str) else text_of(field.value)
                ui.input(label, value=text, on_change=change).props("dense")
            text = field.text.replace("``", "")
            if field.published != field.value:
                origin = "Published" if field.key.startswith("config.") else "Default"
                text = f"{origin}: {text_of(field.published) or 'none'}. {text}"
            hint(text)

    def _request(self) -> RunRequest:
        v = self.values
        if self.fields:
            v["set"] = assignments(self.fields, v["changes"])
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

    def _changed(self, *_: Any) -> None:
        """Show the command, or what is wrong with the form."""
        try:
            request = self._request()
            self._count_changes()
            self.command._text = command_line(request.arguments)
            self.command.update()
            self.error.text = ""
        except TactogramError as error:
            self.error.text = str(error)

    async def _start(self) -> None:
        self.error.text = ""
        request = self._request()
        workspace = self.context.studio.workspace
        folder = workspace.inside(request.folder)
        with busy("Checking model and data", button=self.start):
            try:
                if folder.exists():
                    raise ParameterError(f"{request.folder}: already exists; choose another name")
                await in_background(_check, request, workspace.inside(request.data))
            except TactogramError as error:
                self.error.text = str(error)
                return
            begin = self.context.trainings.begin
            await in_background(begin, "train", request.arguments, request.folder)
        self._discard_changes()
        ui.navigate.to(f"/train/watch?run={quote(request.folder)}")


def _check(request: RunRequest, data: Path) -> None:
    from tactogram.workflows import check_training  # brings torch

    check_training(request.training_request(data))
