import asyncio
import logging

import pytest

from tactogram.errors import ParameterError
from tactogram.studio import layout


def refuse():
    raise ParameterError("expected a, got b")


async def refuse_later():
    refuse()


@pytest.mark.parametrize("handler", [refuse, refuse_later])
def test_an_error_that_comes_when_its_page_was_left_is_logged(handler, caplog, monkeypatch):
    def gone(*_, **__):
        raise RuntimeError("The parent element this slot belongs to has been deleted.")  # NiceGUI's

    monkeypatch.setattr(layout.ui, "notify", gone)
    with caplog.at_level(logging.WARNING):
        found = layout.telling(handler)()
        if handler is refuse_later:
            asyncio.run(found)
    assert [record.getMessage() for record in caplog.records] == [
        "nobody was left to be told: expected a, got b"
    ]
