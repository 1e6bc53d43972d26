import asyncio
import logging

import pytest

from tactogram.errors import ParameterError
from tactogram.studio import layout


def refuse():
    raise ParameterError("expected a, got b")


async def refuse_later():
    refuse()


def refuse_by_another():
    return refuse_later()


@pytest.mark.parametrize("handler", [refuse, refuse_later, refuse_by_another])
def test_an_error_that_comes_when_its_page_was_left_is_logged(handler, caplog, monkeypatch):
    def gone(*_, **__):
        raise RuntimeError("The parent element this slot belongs to has been deleted.")  # NiceGUI's

    monkeypatch.setattr(layout.ui, "notify", gone)
    with caplog.at_level(logging.WARNING):
        found = layout.telling(handler)()
        if asyncio.iscoroutine(found):
            asyncio.run(found)
    assert [record.getMessage() for record in caplog.records] == [
        "nobody was left to be told: expected a, got b"
    ]
