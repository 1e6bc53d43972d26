import json
import os
import shlex

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files.catalogue import haptic_formats
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram_playback.workflows.actuators import calibrate
from tactogram_studio.pages.send.files import losses_table
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.sent import DriveRequest, FileRequest, SendService, level_text
from tactogram_studio.workspace.shelf import ResultArchive


def texture(seed=0, seconds=0.4):
    noise = np.random.default_rng(seed).standard_normal((3, round(1000 * seconds)))
    return Signal(noise.astype(np.float32), 1000, "m/s^2", ("x", "y", "z"))


@pytest.fixture(name="sending")
def sending_fixture(tmp_path):
    """Give a SendService on a workspace with one kept, simulated result; its ``of`` is ``kept:ID``."""
    workspace = Workspace.at(tmp_path)
    sending = SendService(workspace, ResultArchive(workspace.studio_folder / "kept"))
    made = sending.sources.shelf.keep(texture(), title="Cork, at 100 mm/s", facts={"simulated": True})
    sending.of = f"kept:{made.id}"
    return sending


def test_a_drive_is_what_the_command_makes(sending, monkeypatch):
    sent = sending.drive(DriveRequest(sending.of, "voice-coil", "peak=0.5", changes=("linear.cap_db=10",)))
    words = shlex.split(sent.facts["commands"][0])
    monkeypatch.chdir(sending.workspace.folder)
    assert main(words[1:]) == 0
    page, command = (read_signal(path) for path in (sent.folder / "drive.npz", "drive.wav"))
    assert np.array_equal(page.samples, command.samples)
    assert sent.facts["simulated"]


def test_a_drive_is_had_as_wav_csv_and_npz_with_its_report(sending):
    sent = sending.drive(DriveRequest(sending.of, "audio", "gain=0.1"))
    drives = [read_signal(sending.drive_file(sent, suffix)) for suffix in (".wav", ".npz", ".csv")]
    assert all(np.allclose(d.samples, drives[0].samples, atol=1e-6) for d in drives)
    report = json.loads((sent.folder / "drive.report.json").read_text())
    assert report["scaled"] == sent.facts["report"]["scaled"]
    assert (sent.folder / "drive.report.png").stat().st_size > 10_000
    with pytest.raises(ParameterError, match=r"\.wav, \.csv, \.npz"):
        sending.drive_file(sent, ".sh")


def test_what_is_refused_leaves_nothing(sending):
    with pytest.raises(ParameterError):
        sending.drive(DriveRequest(sending.of, "voice-coil", "loud"))
    assert [path for path in sending.folder.iterdir() if not path.name.startswith(".")] == []
    assert list(sending.folder.glob(".*.part")) == []


def test_a_result_is_found_again_after_a_restart(sending):
    request = DriveRequest(sending.of, "audio", "peak=0.2", how="x")
    sent = sending.drive(request)
    again = SendService(sending.workspace, sending.sources.shelf).get(sent.id)
    assert again == sent
    assert again.request == request


def test_a_result_is_of_one_signal_as_it_was(sending):
    other = sending.sources.shelf.keep(texture(1), title="Felt", facts={})
    file = sending.workspace.folder / "take.npz"
    write_signal(file, texture(2))
    cork, felt, take = map(sending.sources.select, (sending.of, f"kept:{other.id}", "file:take.npz"))
    old = sending.drive(DriveRequest(take.id, "audio", "peak=0.2"))
    sending.drive(DriveRequest(cork.id, "audio", "peak=0.2"))
    newest = sending.drive(DriveRequest(cork.id, "audio", "peak=0.3"))
    assert [sending.latest(each, DriveRequest) for each in (cork, felt, take)] == [newest, None, old]
    assert sending.latest(cork, FileRequest) is None

    write_signal(file, texture(3))
    os.utime(file, ns=(1, 1))  # whatever the clock's resolution
    assert sending.latest(take, DriveRequest) is None
    drive = read_signal(old.folder / "drive.npz")  # what was fitted, not what the file holds now
    assert np.array_equal(read_signal(sending.drive_file(old, ".wav")).samples, drive.samples)


@pytest.mark.parametrize("identifier", ["../../kept", "20261122-000000-000000", ""])
def test_no_result_is_an_error_in_a_sentence(sending, identifier):
    with pytest.raises(DataError, match="no result"):
        sending.get(identifier)


@pytest.mark.parametrize("of", ["file:../secret.npz", "file:/etc/passwd", "recording:../x#1"])
def test_nothing_outside_of_the_workspace_is_sent(sending, of):
    with pytest.raises(ParameterError, match="outside"):
        sending.sources.select(of)


def test_a_display_outside_of_the_workspace_is_not_opened(sending):
    with pytest.raises(ParameterError, match="outside"):
        sending.drive(DriveRequest(sending.of, "../mine.toml", "peak=0.5"))


def test_all_formats_come_checked_with_what_they_lose(sending):
    sent = sending.file(FileRequest(sending.of))
    assert set(sent.facts["files"]) == set(haptic_formats())
    assert all(facts["problems"] == [] for facts in sent.facts["files"].values())
    assert all((sent.folder / facts["file"]).is_file() for facts in sent.facts["files"].values())
    rows = losses_table(sent.facts["files"])
    # Three axes in HJIF, one in each of the others.
    assert [row["format"] for row in rows].count("hjif") == 3
    assert len(rows) == 3 + len(haptic_formats()) - 1


def test_one_format_is_the_file_of_the_command(sending, monkeypatch):
    sent = sending.file(FileRequest(sending.of, "ahap", axis="y"))
    monkeypatch.chdir(sending.workspace.folder)
    words = shlex.split(sent.facts["commands"][0])
    assert main(words[1:]) == 0
    name = sent.facts["files"]["ahap"]["file"]
    assert (sending.workspace.folder / name).read_bytes() == (sent.folder / name).read_bytes()


def test_a_format_that_cannot_hold_it_is_named_among_all(sending):
    silent = sending.sources.shelf.keep(
        Signal(np.zeros(400, np.float32), 1000, "1"), title="Silence", facts={}
    )
    files = sending.file(FileRequest(f"kept:{silent.id}")).facts["files"]
    assert "refused" in files["vibration"]
    assert "file" in files["hjif"]
    assert any("refused" in row for row in losses_table(files))


def test_a_recording_is_sent_as_a_file(surfaces):
    workspace = Workspace.at(surfaces)
    sending = SendService(workspace, ResultArchive(workspace.studio_folder / "kept"))
    store = "studio/first/surfaces"
    of, told = next(iter(sending.sources.recordings(store).items()))
    chosen = sending.sources.select(of)
    opened = open_store(surfaces / store)
    identifier = of.partition("#")[2]
    assert np.array_equal(chosen.signal().samples, opened.signal(identifier, "acceleration").samples)
    assert str(opened.info(identifier).material) in told
    assert chosen.simulated


def test_only_files_that_may_be_signals_are_offered(sending):
    write_signal(sending.workspace.folder / "mine.wav", texture().select("x"))
    (sending.workspace.folder / "notes.txt").write_text("no signal\n")
    (sending.workspace.folder / "metrics.jsonl").write_text('{"loss": 1}\n')
    assert list(sending.sources.files()) == ["file:mine.wav"]


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"kind": "drive"}', '{"kind": "file", "title": "", "other": 1}']
)
def test_a_damaged_result_is_an_error_in_a_line(sending, text):
    sent = sending.drive(DriveRequest(sending.of, "audio", "peak=0.2"))
    (sent.folder / "facts.json").write_text(text)
    with pytest.raises(DataError, match=r"facts\.json: (not a JSON document|damaged)") as told:
        sending.get(sent.id)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [("physical", 3.0, "physical"), ("sensation", None, "sensation"), ("peak", 0.5, "peak=0.5")],
)
def test_a_level_is_written_as_the_command_line_takes_it(kind, value, text):
    assert level_text(kind, value) == text


def test_a_signal_over_displacement_needs_a_speed(sending):
    along = Signal(texture().samples[:1], 40, "1", ("x",), "displacement")
    of = f"kept:{sending.sources.shelf.keep(along, title='Felt', facts={}).id}"
    with pytest.raises(ParameterError, match="speed"):
        sending.drive(DriveRequest(of, "audio", "peak=0.5"))
    sent = sending.drive(DriveRequest(of, "audio", "peak=0.5", speed_mm_s=50.0))
    assert "played at 50 mm/s" in sent.facts["report"]["scaled"][0]
    assert "--speed 50" in sent.facts["commands"][0]
    with pytest.raises(ParameterError, match="speed|moves"):
        sending.file(FileRequest(of, "ahap"))
    assert "--play-at 50" in sending.file(FileRequest(of, "ahap", play_at=50.0)).facts["commands"][0]


def test_a_persons_calibration_is_taken(sending):
    folder = sending.workspace.folder
    rows = [
        f"{who},{v},{0.3 * (1 + k_e * v**2 / 0.5)},0.5"
        for who, k_e in (("anna", 2e-5), ("ben", 4e-5))
        for v in (0, 0, 40, 40, 70, 70, 100, 100)
    ]
    (folder / "pairs.csv").write_text(
        "\n".join(["person,voltage_v_rms,friction,normal_force_n", *rows]) + "\n"
    )
    calibrate(folder / "pairs.csv", folder / "people.toml")
    mu = 0.34 + 0.04 * np.sin(2 * np.pi * np.arange(2000) / 2000)
    of = f"kept:{sending.sources.shelf.keep(Signal(mu.astype(np.float32), 4000, '1'), title='Friction', facts={}).id}"
    assert list(sending.calibrations()) == ["people.toml"]
    peaks = []
    for person in ("anna", "ben"):
        request = DriveRequest(of, "electrovibration", "physical", calibration="people.toml", person=person)
        peaks.append(sending.drive(request).facts["report"]["drive"]["peak"])
    # Twice the force per volt squared needs the root of half of it.
    assert peaks[0] / peaks[1] == pytest.approx(2**0.5, rel=0.02)
