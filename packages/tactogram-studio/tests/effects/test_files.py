import json

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files import haptic_formats, read_haptic
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.editor import Editor
from tactogram_studio.effects.effect import Effect, Track
from tactogram_studio.effects.files import SavedEffects, WrittenFiles, feel_path, file_by_ticket
from tactogram_study.participants.tickets import SessionKeys

KEYS = SessionKeys("j" * 16, bytes(32))


def effect(title="Warning", **values):
    return Effect(title=title, tracks=(ready_track(title.lower().replace(" ", "-")),), **values)


@pytest.mark.parametrize("format", haptic_formats())
def test_the_audition_is_what_the_file_encodes(format, tmp_path):
    file = WrittenFiles(tmp_path).write(effect(), format)
    read = read_haptic(file.path, format=format).signal
    assert np.array_equal(file.signal().samples, read.samples)
    assert file.told[0].startswith("The file ")
    assert file.told[1].startswith("Verdict: ")
    pattern = file.pattern()
    # Two pulses of 0.16 s, 0.1 s apart; a few ms of silence may come first.
    pulses = pattern[2:] if pattern[0] == 0 else pattern
    assert pulses == pytest.approx([155, 100, 155], abs=30)


def test_the_phone_gets_exactly_the_pattern_of_a_pattern(tmp_path):
    files = WrittenFiles(tmp_path)
    file = files.write(effect(), "vibration")
    assert file.pattern() == json.loads(file.path.read_text())["pattern"]
    own, _ = files.upload("mine.json", b"[10, 20, 30]")
    assert own.pattern() == [10, 20, 30]


def test_a_mix_above_full_scale_is_said_to_be_scaled(tmp_path):
    loud = Effect(tracks=tuple(ready_track("buzz") for _ in range(4)), simulated=True)
    file = WrittenFiles(tmp_path).write(loud, "ahap")
    assert "The strongest moment is 1.6" in file.told[2]
    assert "0.62 times as strong" in file.told[2]
    assert file.simulated
    assert read_haptic(file.path).metadata == {"simulated": True}


def test_nothing_is_left_of_what_cannot_be_written_or_read(tmp_path):
    files = WrittenFiles(tmp_path)
    with pytest.raises(ParameterError, match="nothing to play"):
        files.write(Effect(tracks=(Track(),)), "ahap")
    with pytest.raises(DataError, match=r"^bad.ahap: not valid AHAP"):
        files.upload("bad.ahap", b'{"Pattern": [{}]}')
    with pytest.raises(ParameterError, match=r"expected one of \.ahap"):
        files.upload("x.wav", b"RIFF")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_old_files_make_room(tmp_path, monkeypatch):
    monkeypatch.setattr("tactogram_studio.effects.files.MOST_FILES", 2)
    files = WrittenFiles(tmp_path)
    first, *_, last = [files.write(effect(), "haptic") for _ in range(3)]
    assert files.get(last.id) == last
    with pytest.raises(DataError, match="deleted to make room"):
        files.get(first.id)


def test_a_ticket_leads_to_its_own_file_only(tmp_path):
    files = WrittenFiles(tmp_path)
    one, other = files.write(effect(), "ahap"), files.write(effect(), "haptic")
    ticket = feel_path(one, KEYS).removeprefix("/feel/")
    assert file_by_ticket(ticket, files, KEYS) == one
    forged = (
        ticket.replace(one.id, other.id), one.id, f"{one.id}~", ticket[:-1], "", "~", "../x~y", "é~é",
    )  # fmt: skip
    for text in forged:
        with pytest.raises(DataError):
            file_by_ticket(text, files, KEYS)
    with pytest.raises(DataError, match="no such file"):
        file_by_ticket(ticket, files, SessionKeys("j" * 16, bytes(31) + b"1"))


def ready(*titles):
    editor = Editor(Effect())
    for title in titles:
        editor.insert((ready_track(title.lower().replace(" ", "-")),))
    return editor


def test_a_saved_effect_is_replaced_listed_and_deleted(tmp_path):
    saved = SavedEffects(tmp_path / "effects")
    effect = ready("Tap").effect.changed(title="Mine")
    first = saved.add(Effect())
    assert saved.save(first, effect, before=Effect()) == effect
    assert (saved.get(first), saved.titles()) == (effect, {first: "Mine"})
    (tmp_path / "effects" / first / "effect.json").write_text("{")
    assert saved.titles() == {}
    saved.remove(first)
    with pytest.raises(DataError, match="it was deleted"):
        saved.save(first, effect, before=effect)


def test_an_effect_that_another_tab_has_changed_is_not_overwritten(tmp_path):
    saved = SavedEffects(tmp_path / "effects")
    tap, buzz = (ready(title).effect for title in ("Tap", "Buzz"))
    first = saved.add(Effect())
    saved.save(first, tap, before=Effect())

    assert saved.save(first, buzz, before=Effect()) == tap
    assert saved.get(first) == tap
    assert saved.save(first, buzz, before=tap) == saved.get(first) == buzz
