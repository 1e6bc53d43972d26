"""Kit of parts that all pages are built of: frame, cards, fields, files, signals, tables, dialogs, tasks."""

from tactogram_studio.kit.cards import (
    alert,
    attribute,
    card,
    code,
    column,
    command_lines,
    heading,
    hint,
    icon_button,
    mark_simulated,
    refusals,
    set_text,
)
from tactogram_studio.kit.dialogs import ask_title, confirm, form_dialog
from tactogram_studio.kit.fields import Form, NumberField, declared_field, in_range
from tactogram_studio.kit.files import file_button, file_field
from tactogram_studio.kit.signals import KINDS, option_choice, signal_choice
from tactogram_studio.kit.tables import table, table_head
from tactogram_studio.layout import busy, in_background, page, route

__all__ = [
    "KINDS",
    "Form",
    "NumberField",
    "alert",
    "ask_title",
    "attribute",
    "busy",
    "card",
    "code",
    "column",
    "command_lines",
    "confirm",
    "declared_field",
    "file_button",
    "file_field",
    "form_dialog",
    "heading",
    "hint",
    "icon_button",
    "in_background",
    "in_range",
    "mark_simulated",
    "option_choice",
    "page",
    "refusals",
    "route",
    "set_text",
    "signal_choice",
    "table",
    "table_head",
]
