"""Page for addresses that do not exist, with the navigation and the way back."""

from __future__ import annotations

from fastapi.exception_handlers import http_exception_handler
from nicegui import Client, app, ui
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from tactogram_studio.layout import page


def add(*, navigation: bool = True) -> None:
    """Replace NiceGUI's page; without ``navigation`` there is no start page to return to."""

    @app.exception_handler(404)
    async def not_found(request: Request, error: HTTPException) -> Response:
        if request.scope.get("endpoint") not in (None, app):  # a route's own answer
            return await http_exception_handler(request, error)
        with Client(ui.page(""), request=request) as client, page("Page not found", navigation=navigation):
            ui.label(f"There is no page at {request.url.path[:200]}. Check the address, or go back.")
            with ui.row():
                ui.button("Go back", on_click=ui.navigate.back)
                if navigation:
                    ui.button("Start page", on_click=lambda: ui.navigate.to("/")).props("outline")
        return client.build_response(request, 404)
