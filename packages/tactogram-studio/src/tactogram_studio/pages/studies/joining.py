"""Card of the experimenter's page for joining: address with QR code, and enrolment in advance."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from nicegui import ui

from tactogram_studio import kit
from tactogram_studio.server.listening import is_loopback, svg_qr_code
from tactogram_study.wording import own_name

if TYPE_CHECKING:
    from tactogram_study.participants.sessions import OpenSession


class JoinCard:
    """The card "Take part"; calls ``changed`` after an enrolment.

    ``server`` is the beginning of addresses in the experimenter's browser, ``roots`` those for other machines.
    """

    def __init__(
        self,
        session: OpenSession,
        server: str,
        roots: tuple[str, ...],
        changed: Callable[[], Awaitable[Any]],
    ) -> None:
        self.session, self.server, self.changed = session, server, changed
        reachable = reachable_roots(server, roots)
        self.root = reachable[0]
        self.card = ui.element("section").classes("card w-full stack")
        with self.card:
            kit.heading("Take part")
            kit.hint("Participants open this address, and begin or continue with their code.")
            if len(reachable) > 1:
                select = ui.select(list(reachable), value=self.root, label="This machine's address")
                select.classes("w-full").on_value_change(self._choose)
            self.address = ui.column().classes("w-full gap-2")
            self._show()
            ui.separator()
            self._form()

    @property
    def loopback(self) -> bool:
        """Whether the addresses work on this machine only, so that QR codes are useless."""
        return is_loopback(urlsplit(self.root).hostname or "")

    def local_address(self, code: str) -> str:
        """Return the address of a participant's pages for the experimenter's browser."""
        return f"{self.server}{self.session.take_path(code)}"

    def show_qr_code(self, code: str) -> None:
        """Show the address of a participant's pages as a QR code."""
        with ui.dialog(value=True) as dialog, ui.card().classes("items-center"):
            kit.heading(f"Pages of {code}")
            _address(f"{self.root}{self.session.take_path(code)}", f"Address of the pages of {code}")
            kit.hint("It leads to this participant's pages only.")
            ui.button("Close", on_click=dialog.close).props("flat")
        dialog.on("hide", dialog.delete)

    def _show(self) -> None:
        self.address.clear()
        address = f"{self.root}{self.session.join_path}"
        with self.address:
            _address(address, "Address to take part", qr_code=not self.loopback)
            ui.button("Copy", on_click=lambda: ui.clipboard.write(address)).props("outline dense")
            if self.loopback:
                kit.hint(
                    "This address works on this machine only. For tablets, start with --host 0.0.0.0 --https."
                )

    def _choose(self, event: Any) -> None:
        self.root = event.value
        self._show()

    def _form(self) -> None:
        languages = {name: own_name(name) for name in self.session.study.languages}
        self.code = ui.input("Code (empty: random)").props("maxlength=16").classes("w-full")
        self.language = ui.select(languages, value=next(iter(languages)), label="Language")
        self.language.classes("w-full")
        ui.button("Enrol", on_click=self._enrol)
        self.enrolled = ui.column().classes("w-full gap-1")

    async def _enrol(self) -> None:
        code = (self.code.value or "").strip() or None
        participant = await kit.in_background(self.session.store.enrol, code, language=self.language.value)
        self.code.value = ""
        with self.enrolled, ui.row().classes("items-center gap-2"):
            ui.label(participant.code).classes("h2")
            ui.link("Open their pages", self.local_address(participant.code), new_tab=True)
        await self.changed()


def reachable_roots(server: str, roots: tuple[str, ...]) -> tuple[str, ...]:
    """Return the beginnings of addresses that participants' devices can open, the likeliest first.

    ``server``, in the experimenter's browser, may be a name of this machine only, one of ``roots``, or a proxy's.
    """
    if server in roots:
        return tuple(dict.fromkeys((server, *roots)))
    return (*roots, server) if not roots or not is_loopback(urlsplit(server).hostname or "") else roots


def _address(address: str, name: str, *, qr_code: bool = True) -> None:
    if qr_code:
        image = ui.element("img").classes("qr")
        image.props.update(src=svg_qr_code(address), alt=f"QR code: {name}")
    link = ui.link(address, address, new_tab=True).classes("break-all")
    link.props["aria-label"] = f"{name}: {address}"
