"""The form that begins a training: model, data, recipe, what is changed of it, and how the data is split."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.models import ModelInfo, available
from tactogram.studio.layout import busy, in_background, report_errors
from tactogram.studio.pages.train.config_form import RecipeField, assignments, settings_of, shown
from tactogram.studio.pages.train.request import BYS, SPLIT_TEXTS, SPLITS, RunRequest, describe_model
from tactogram.studio.pages.train.trainings import command_line, free_name
from tactogram.studio.pages.train.widgets import TrainContext

KEPT = "train"
"""Under which the form's values survive a reload."""
USUAL = {"split": "", "last": 2, "by": "recording", "label": "material", "where": "", "name": ""}


def draw(desk: TrainContext, *, model: str = "", data: str = "") -> None:
    """Draw the form; ``model`` and ``data`` choose them beforehand."""
    workspace = desk.studio.workspace
    models = available()
    stores = [workspace.name_of(path) for path in workspace.stores()]
    values: dict[str, Any] = app.storage.user.setdefault(KEPT, {})
    for name, usual in USUAL.items():
        values.setdefault(name, usual)
    values.setdefault("changes", {})
    values["model"] = model if model in models else _kept(values, "model", models, "texture_gan")
    values["data"] = data if data in stores else _kept(values, "data", stores, stores[0] if stores else None)
    ui.label("Start a training").classes("h2").props('role="heading" aria-level="2"')
    if not stores:
        ui.label("There is no data set in this workspace yet.")
        ui.link("Simulate or import one", "/materials")
        return
    _TrainingForm(desk, models, stores, values).draw()


def _kept(values: dict[str, Any], name: str, known: Any, usual: Any) -> Any:
    kept = values.get(name)
    return kept if kept in known else usual


class _TrainingForm:
    """Widgets bound to values that a reload keeps."""

    def __init__(
        self, desk: TrainContext, models: dict[str, ModelInfo], stores: list[str], values: dict[str, Any]
    ) -> None:
        self.desk, self.models, self.stores, self.values = desk, models, stores, values
        self.settings: list[RecipeField] = []

    @property
    def facts(self) -> ModelInfo:
        return self.models[self.values["model"]]

    def draw(self) -> None:
        with ui.column().classes("w-full gap-2 items-stretch"):
            ui.select(
                list(self.models), label="Model", value=self.values["model"], on_change=self._model
            ).props("options-dense")
            self.about = ui.label().classes("small quiet")
            ui.select(self.stores, label="Data set", value=self.values["data"], on_change=self._data)
            self.recipe = ui.select([], label="Recipe", on_change=self._recipe)
            self.recipe_text = ui.label().classes("small quiet")
            split = (
                ui.select(SPLITS, label="Split")
                .bind_value(self.values, "split")
                .on_value_change(self._changed)
            )
            ui.label().classes("small quiet").bind_text_from(self.values, "split", SPLIT_TEXTS.__getitem__)
            last = ui.number("How many of each material", min=1, precision=0)
            last.bind_value(self.values, "last").on_value_change(self._changed)
            last.bind_visibility_from(split, "value", value="last")
            with ui.expansion("More about the data").classes("w-full").props("dense"):
                ui.select(BYS, label="Kept together").bind_value(self.values, "by").on_value_change(
                    self._changed
                )
                ui.input("Class", placeholder="material").bind_value(self.values, "label").on_value_change(
                    self._changed
                ).tooltip("Fields that make a class, such as material+contactor")
                ui.input("Only recordings with", placeholder="contactor=finger").bind_value(
                    self.values, "where"
                ).on_value_change(self._changed)
            self.more = ui.button("Values of the recipe", on_click=report_errors(self._open)).props("outline")
            self.dialog = ui.dialog().props('full-width aria-label="Values of the recipe"')
            self.name = (
                ui.input("Name of the run").bind_value(self.values, "name").on_value_change(self._changed)
            )
            ui.label("Equal command").classes("small quiet")
            self.command = (
                ui.element("code").classes("small").style("overflow-wrap: anywhere; display: block")
            )
            self.refused = ui.label().classes("text-negative").props('role="alert"')
            self.start = ui.button("Start", on_click=report_errors(self._start)).classes("w-full")
        self._fill()
        self._changed()  # what a reload kept is set without a change

    def _fill(self) -> None:
        """Show what belongs to the chosen model."""
        self.about.text = describe_model(self.facts)
        recipes = list(self.facts.recipes())
        chosen = _kept(self.values, "recipe", recipes, "quick" if "quick" in recipes else recipes[0])
        self.values["recipe"] = chosen
        self.recipe.set_options(recipes, value=chosen)
        self._say_recipe()
        self._name()
        self._drop_settings()

    def _say_recipe(self) -> None:
        lines = self.facts.recipe(self.values["recipe"]).read_text(encoding="utf-8").split("\n")
        head = " ".join(line.lstrip("# ") for line in lines if line.startswith("#"))
        self.recipe_text.text = head

    def _name(self) -> None:
        place = self.desk.studio.workspace.folder / "runs"
        self.name.value = free_name(place, f"{self.values['model']}-{self.values['recipe']}")

    def _model(self, event: Any) -> None:
        self.values["model"] = event.value
        self.values["changes"], self.values["set"] = {}, []
        self._fill()
        self._changed()

    def _data(self, event: Any) -> None:
        self.values["data"] = event.value
        self._changed()

    def _recipe(self, event: Any) -> None:
        if event.value and event.value != self.values["recipe"]:
            self.values["recipe"] = event.value
            self.values["changes"], self.values["set"] = {}, []
            self._say_recipe()
            self._name()
            self._drop_settings()
            self._changed()

    def _drop_settings(self) -> None:
        self.settings = []
        self._count()

    def _count(self) -> None:
        changed = len(self.values.get("set") or [])
        self.more.text = "Values of the recipe" + (f" ({changed} changed)" if changed else "")

    async def _open(self) -> None:
        if not self.settings:
            with busy("reading the model's own values", button=self.more):
                self.settings = await in_background(settings_of, self.facts, self.values["recipe"])
            self.dialog.clear()
            with self.dialog, ui.card().classes("w-full"):
                ui.label(f"Values of {self.values['model']}, recipe {self.values['recipe']}").classes(
                    "h2"
                ).props('role="heading" aria-level="2"')
                with ui.element("div").classes("tiles w-full"):
                    for setting in self.settings:
                        self._setting(setting)
                ui.button("Done", on_click=self.dialog.close)
        self.dialog.open()

    def _setting(self, setting: RecipeField) -> None:
        given = self.values["changes"].get(setting.key)
        value = setting.value if given is None else given

        def change(event: Any) -> None:
            self.values["changes"] = {**self.values["changes"], setting.key: event.value}
            self._changed()

        with ui.column().classes("w-full gap-0 items-stretch"):
            label = setting.key.removeprefix("config.")
            if setting.widget == "switch":
                ui.switch(label, value=bool(value), on_change=change)
            elif setting.widget == "choice":
                ui.select(list(setting.choices), label=label, value=value, on_change=change).props("dense")
            elif setting.widget in ("integer", "number"):
                ui.number(label, value=value, on_change=change, format="%.6g").props("dense")
            else:
                text = given if isinstance(given, str) else shown(setting.value)
                ui.input(label, value=text, on_change=change).props("dense")
            of_model = setting.key.startswith("config.")
            differs = setting.published != setting.value
            usual = (
                f"{'Published' if of_model else 'Usual'}: {shown(setting.published) or 'none'}. "
                if differs
                else ""
            )
            ui.label(usual + setting.text.replace("``", "")).classes("small quiet")

    def _order(self) -> RunRequest:
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

    def _changed(self, *_: Any) -> None:
        """Show the command, or what is wrong with the form."""
        try:
            order = self._order()
            self._count()
            self.command._text = command_line(order.arguments)
            self.command.update()
            self.refused.text = ""
        except TactogramError as error:
            self.refused.text = str(error)

    async def _start(self) -> None:
        self.refused.text = ""
        order = self._order()
        workspace = self.desk.studio.workspace
        folder = workspace.inside(order.run)
        with busy("looking whether data and model fit", button=self.start):
            try:
                if folder.exists():
                    raise ParameterError(f"{order.run}: is there already; give another name")
                await in_background(_check, order, workspace.inside(order.data))
            except TactogramError as error:
                self.refused.text = str(error)
                return
            await in_background(self.desk.trainings.begin, "train", order.arguments, order.run)
        self.values["changes"], self.values["set"] = {}, []
        ui.navigate.to(f"/train/watch?run={quote(order.run)}")


def _check(order: RunRequest, data: Path) -> None:
    from tactogram.workflows.training.compatibility import check_training  # brings torch

    check_training(order.asked(data))
