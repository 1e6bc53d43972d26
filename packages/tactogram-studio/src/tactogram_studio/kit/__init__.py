"""Kit of parts that all pages are built of: frame, cards, fields, files, signals, tables, dialogs, tasks."""

from tactogram_studio.kit.cards import (
    alert as alert,
    ask_title as ask_title,
    card as card,
    code as code,
    column as column,
    command_lines as command_lines,
    confirm as confirm,
    form_dialog as form_dialog,
    heading as heading,
    hint as hint,
    icon_button as icon_button,
    in_fields as in_fields,
    line_chart as line_chart,
    mark_simulated as mark_simulated,
    refusals as refusals,
    table as table,
    table_head as table_head,
    title_row as title_row,
)
from tactogram_studio.kit.fields import (
    KINDS as KINDS,
    Form as Form,
    NumberField as NumberField,
    TabSettings as TabSettings,
    declared_field as declared_field,
    file_button as file_button,
    file_field as file_field,
    in_range as in_range,
    option_choice as option_choice,
    signal_choice as signal_choice,
)
from tactogram_studio.kit.parameters import ParameterFields as ParameterFields, value_of as value_of
from tactogram_studio.layout import (
    address as address,
    attribute as attribute,
    busy as busy,
    call_workflow as call_workflow,
    in_background as in_background,
    keep_address as keep_address,
    page as page,
    route as route,
)
