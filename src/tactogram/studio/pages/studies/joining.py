"""Part of the experimenter's page: the address to take part, also as a QR code, and codes enrolled beforehand."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from nicegui import ui

from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.server.listening import is_loopback
from tactogram.studio.server.qr_code import svg_qr_code

if TYPE_CHECKING:
    from tactogram.studio.participants.sessions import OpenSession

LANGUAGES = {"ja": "Japanese", "en": "English"}


class JoinCard:
    """The card "Take part".

    Parameters
    ----------
    opened : OpenSession
    server : str
        How the address begins under which the experimenter's browser reached the page.
    roots : tuple of str
        How those begin by which other machines reach this one.
    changed : callable
        Called when somebody was enrolled.
    """

    def __init__(
        self,
        opened: OpenSession,
        server: str,
        roots: tuple[str, ...],
        changed: Callable[[], Awaitable[Any]],
    ) -> None:
        self.opened, self.server, self.changed = opened, server, changed
        reached = reached_at(server, roots)
        self.root = reached[0]
        self.card = ui.element("section").classes("card w-full stack")
        with self.card:
            ui.label("Take part").classes("h2")
            ui.label("Participants open this address, and begin or go on by their code.").classes(
                "quiet small"
            )
            if len(reached) > 1:
                ui.select(list(reached), value=self.root, label="This machine's address").props(
                    "dense"
                ).classes("w-full").on_value_change(self._choose)
            self.address = ui.column().classes("w-full gap-2")
            self._show()
            ui.separator()
            self._form()

    @property
    def alone(self) -> bool:
        """Whether the addresses lead nowhere on another device, so that a QR code of them would be of no use."""
        return is_loopback(urlsplit(self.root).hostname or "")

    def pages_here(self, code: str) -> str:
        """Return the address of a participant's pages for the experimenter's browser."""
        return f"{self.server}{self.opened.take_path(code)}"

    def show_qr_code(self, code: str) -> None:
        """Show the address of a participant's pages as a QR code."""
        with ui.dialog(value=True) as dialog, ui.card().classes("items-center"):
            ui.label(f"Pages of {code}").classes("h2")
            address, what = f"{self.root}{self.opened.take_path(code)}", f"Address of the pages of {code}"
            _drawn(address, what)
            _linked(address, what)
            ui.label("It leads to this participant's pages, and to no others.").classes("quiet small")
            ui.button("Close", on_click=dialog.close).props("flat")
        dialog.on("hide", dialog.delete)

    def _show(self) -> None:
        self.address.clear()
        address = f"{self.root}{self.opened.join_path}"
        with self.address:
            if not self.alone:
                _drawn(address, "Address to take part")
            _linked(address, "Address to take part")
            ui.button("Copy", on_click=lambda: ui.clipboard.write(address)).props("outline dense")
            if self.alone:
                ui.label(
                    "This address works on this machine alone. For tablets, begin with --host 0.0.0.0 --https."
                ).classes("quiet small")

    def _choose(self, event: Any) -> None:
        self.root = event.value
        self._show()

    def _form(self) -> None:
        languages = {name: LANGUAGES[name] for name in self.opened.study.languages}
        self.code = ui.input("Code (empty: one is drawn)").props("dense maxlength=16").classes("w-full")
        self.language = (
            ui.select(languages, value=self.opened.study.languages[0], label="Language")
            .props("dense")
            .classes("w-full")
        )
        ui.button("Enrol", on_click=report_errors(self._enrol))
        self.enrolled = ui.column().classes("w-full gap-1")

    async def _enrol(self) -> None:
        wanted = (self.code.value or "").strip() or None
        participant = await in_background(self.opened.store.enrol, wanted, language=self.language.value)
        self.code.value = ""
        with self.enrolled, ui.row().classes("items-center gap-2"):
            ui.label(participant.code).classes("h2")
            ui.link("open their pages", self.pages_here(participant.code), new_tab=True)
        await self.changed()


def reached_at(server: str, roots: tuple[str, ...]) -> tuple[str, ...]:
    """Return how the addresses begin that people's devices can open, the likeliest first.

    Parameters
    ----------
    server : str
        As the experimenter opened the page: a name of this machine alone, one of ``roots``, or the name of a proxy.
    roots : tuple of str
        By which other machines reach this one; none where none does.
    """
    if server in roots:
        return tuple(dict.fromkeys((server, *roots)))
    return (*roots, server) if not roots or not is_loopback(urlsplit(server).hostname or "") else roots


def _drawn(address: str, what: str) -> None:
    image = ui.element("img").classes("qr")
    image.props.update(src=svg_qr_code(address), alt=f"QR code: {what}")


def _linked(address: str, what: str) -> None:
    ui.link(address, address, new_tab=True).classes("break-all").props(f'aria-label="{what}: {address}"')
