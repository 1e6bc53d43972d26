"""Small valid inputs of every kind that tactogram reads, by folder, and the commands that read them."""

from __future__ import annotations

import bz2
import gzip
import lzma
import shutil
import zipfile
from collections.abc import Callable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas
import soundfile
from PIL import Image as Pillow
from scipy.io import savemat
from tests.datasets.importers.sample_files import write_photo, write_sound
from tests.signal.io.sample_files import hdf5, noise, tdms

from tactogram.cli import main
from tactogram.datasets import Ratings, Recording, create_store
from tactogram.rendering.files import haptic_format, haptic_formats, write_haptic
from tactogram.signal import Signal
from tactogram.signal.io import read_image, write_signal
from tactogram.workflows.training.train import train

ROOT = Path(__file__).parents[2]
FACTS = {"name": "made up", "licence": "-", "simulated": True}
CONDITIONS = [
    {"file": "a.wav", "material": "cork", "seconds": 0.2, "seed": 3},
    {"mix": {"cork": 0.6, "tile": 0.4}, "seconds": 0.2},
]
STUDY = {
    "title": "Small",
    "consent": "Do you agree?",
    "level": "gain=0.1",
    "design": {"kind": "rating", "words": ["rough", "dry"]},
    "stimuli": [{"name": name, "item": name, "file": "buzz.wav"} for name in ("buzz", "hum")],
}


def module(place: str) -> ModuleType:
    """Return a module of the packages' tests, whose writers of files are used here."""
    spec = spec_from_file_location(Path(place).stem, ROOT / "packages" / place)
    assert spec is not None
    assert spec.loader is not None
    loaded = module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def of_set(name: str) -> ModuleType:
    """Return the tests of a data set's importer."""
    return module(f"tactogram-benchmark/tests/importers/test_{name}.py")


def toml(path: Path, values: dict) -> None:
    """Write a TOML file."""
    import tomli_w

    path.write_text(tomli_w.dumps(values))


def stroke(seed: int, *, seconds: float = 1.0) -> Signal:
    """Return simulated acceleration."""
    samples = np.random.default_rng(seed).standard_normal((3, round(1000 * seconds)))
    return Signal(np.cumsum(samples, 1) * (0.2 + 0.1 * (seed % 2)), 1000.0, "m/s^2")


def signals(folder: Path) -> None:
    for suffix in ("wav", "flac", "csv", "tsv", "npz", "xlsx"):
        write_signal(folder / f"own.{suffix}", noise(length=60, level=1.0), metadata={"simulated": True})
    samples = np.random.default_rng(0).uniform(-0.5, 0.5, (400, 2))
    for suffix in ("aiff", "au", "caf", "w64", "rf64", "ogg", "mp3"):
        soundfile.write(folder / f"sound.{suffix}", samples, 44100)
    for path in (ROOT / "tests" / "signal" / "io" / "foreign" / "files").glob("*/*.*"):
        shutil.copy(path, folder / f"{path.parent.name}-{path.name}")
    table = {"t": np.arange(60) / 500, "ax": samples[:60, 0], "ay": samples[:60, 1]}
    savemat(folder / "a.mat", table)
    savemat(folder / "run.mat", {"run": {"acc": samples[:60], "Fs": 500.0}}, do_compression=True)
    hdf5(folder / "a.h5")
    tdms(folder / "a.tdms")
    frame = pandas.DataFrame(table)
    frame.to_parquet(folder / "a.parquet")
    frame.to_feather(folder / "a.feather")
    frame.to_json(folder / "a.jsonl", orient="records", lines=True)
    np.savez(folder / "foreign.npz", **table)
    text = frame.to_csv(index=False).encode()
    for suffix, packer in (("gz", gzip), ("bz2", bz2), ("xz", lzma)):
        (folder / f"a.csv.{suffix}").write_bytes(packer.compress(text))
    with zipfile.ZipFile(folder / "a.zip", "w") as archive:
        archive.writestr("Accelerometer.csv", text)


def haptic(folder: Path) -> None:
    burst = Signal(np.sin(np.arange(400)) * np.hanning(400), 2000.0, "1")
    for name in haptic_formats():
        write_haptic(folder / f"{name}{haptic_format(name).suffix}", burst, format=name)
    for path in (ROOT / "tests" / "rendering" / "files" / "cases").iterdir():
        shutil.copy(path, folder)


def pictures(folder: Path) -> None:
    for suffix in ("png", "jpg", "tiff", "bmp", "webp"):
        write_photo(folder / f"a.{suffix}", 3)
    Pillow.new("I;16", (30, 20)).save(folder / "grey.png")


def recordings(folder: Path) -> None:
    for number, material in enumerate(("cork", "tile")):
        (folder / material).mkdir(parents=True)
        write_signal(folder / material / "1.wav", stroke(number))
        write_signal(folder / material / "2.csv", stroke(number + 7, seconds=0.1))
        write_photo(folder / material / "photo.png", number)
    (folder / "recordings.csv").write_text("file,speed_mm_s,force_n,subject\ncork/1.wav,100,0.5,s1\n")


def other(folder: Path) -> None:
    store(folder, first=100)


def store(folder: Path, *, first: int = 0) -> None:
    folder.rmdir()
    image = read_image(_photo(folder))
    held = [
        Recording(
            streams={"acceleration": stroke(first + number)},
            material=("cork", "tile")[number % 2],
            speed_mm_s=100.0,
            force_n=0.5,
            labels={"item": f"i{number}"},
            source=f"{number}.wav",
            image=image if number < 2 else None,
            simulated=True,
        )
        for number in range(8)
    ]
    cells = [(f"r{r}", f"i{i}", w, float(1 + (r + i) % 7)) for r in range(3) for i in range(8) for w in WORDS]
    rater, item, word, value = zip(*cells, strict=True)
    ratings = Ratings(rater, item, word, np.array(value), words=WORDS)
    create_store(folder, held, ratings=ratings, **FACTS)


WORDS = ("rough", "sticky")


def _photo(folder: Path) -> Path:
    path = folder.parent / "photo" / "a.png"
    write_photo(path, 1)
    return path


def _run(model: str, **options) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        train(model, folder.parent / "store", out=folder, accelerator="cpu", **options)

    return make


def tables(folder: Path) -> None:
    """Ratings, answers, pairs of voltage and friction, admittance, motion, sweeps."""
    rows = [
        "rater,item,word,score",
        *(f"r{r},i{i},rough,{1 + (r + i) % 7}" for r in range(3) for i in range(8)),
    ]
    (folder / "ratings.csv").write_text("\n".join(rows) + "\n")
    pairs = ["person,voltage_v_rms,friction,normal_force_n"]
    pairs += [
        f"p1,{v},{0.3 * (1 + 2e-5 * v * v / 0.5) + 0.001 * (k % 3)},0.5"
        for k, v in enumerate([0, 40, 60, 80, 100] * 4)
    ]
    (folder / "pairs.csv").write_text("\n".join(pairs) + "\n")
    from tactogram_playback.transducer.circuit import Transducer

    circuit = Transducer()
    hz = circuit.resonance_hz + np.linspace(-600, 600, 41)
    found = circuit.admittance(hz)
    sweep = [f"{f},{y.real},{y.imag}" for f, y in zip(hz, found, strict=True)]
    (folder / "admittance.csv").write_text(
        "\n".join(["frequency_hz,conductance_s,susceptance_s", *sweep]) + "\n"
    )
    motion = [f"{t / 10},{100 + t},{0.5},{t},{0}" for t in range(10)]
    (folder / "motion.csv").write_text("\n".join(["time_s,speed_mm_s,force_n,x_mm,y_mm", *motion]) + "\n")


def settings(folder: Path) -> None:
    """Conditions, mapping, recipe, study, plan."""
    toml(folder / "conditions.toml", {"condition": CONDITIONS})
    (folder / "conditions.csv").write_text(
        'file,material,mix,seconds\na.wav,cork,,0.2\nb.wav,,"cork=0.6,tile=0.4",0.2\n'
    )
    columns = {"columns": ["x", "y", "z"], "axes": {"x": "x", "y": "y"}, "unit": "g", "rate": 1000.0}
    toml(folder / "mapping.toml", {"layout": [columns]})
    toml(folder / "recipe.toml", {"model": "ar_texture", "seed": 3, "prepare": {"length": 0.5}, "config": {}})
    toml(folder / "names.toml", {"model": "stroke_statistics", "prepare": {"length": 0.5}})
    toml(folder / "study.toml", STUDY)
    write_signal(folder / "buzz.wav", Signal(np.sin(np.arange(800)), 2000.0, "1"))
    plan = {"materials": ["cork", "tile"], "contactors": ["finger"], "speeds_mm_s": [100], "repetitions": 1}
    plan |= {
        "seconds": 0.2,
        "countdown_s": 0.0,
        "metronome": False,
        "rate": 330.0,
        "limits": {"most_lost": 0.5},
    }
    toml(folder / "plan.toml", plan)
    shutil.copy(
        ROOT / "src" / "tactogram" / "rendering" / "displays" / "voice-coil.toml", folder / "display.toml"
    )


def waves(folder: Path) -> None:
    write_signal(folder / "a.wav", stroke(1, seconds=0.2))
    write_signal(folder / "friction.npz", Signal(stroke(1).samples[:1], 40.0, "1", domain="displacement"))


def calibrated(folder: Path) -> None:
    pairs, out = str(folder.parent / "tables" / "pairs.csv"), str(folder / "p.toml")
    assert main(["calibrate", pairs, "--out", out, "--quiet"]) == 0


def answers(folder: Path) -> None:
    out = str(folder / "answers.csv")
    assert main(["study", "export", str(folder.parent / "session"), "--out", out, "--quiet"]) == 0


def sweep(folder: Path) -> None:
    assert main(["sweep", "voice-coil", "--seconds", "1", "--out", str(folder / "sweep.wav"), "--quiet"]) == 0


def packed(folder: Path) -> None:
    out = folder / "names.zip"
    assert main(["run", "export", str(folder.parent / "names"), "--out", str(out), "--quiet"]) == 0


def session(folder: Path) -> None:
    study, out = folder.parent / "study.toml", str(folder)
    toml(study, STUDY)
    write_signal(study.with_name("buzz.wav"), Signal(np.sin(np.arange(800)), 2000.0, "1"))
    assert main(["study", "simulate", str(study), "--participants", "3", "--out", out, "--quiet"]) == 0


def logs(folder: Path) -> None:
    """What receivers, boards and the lab streaming layer wrote."""
    from tactogram_capture.twelite.simulator import SimulatedReceiver, write_log

    written = module("tactogram-capture/tests/test_logs.py")
    write_log(folder / "raw.log", SimulatedReceiver(seconds=1, loss=0.05, seed=4))
    written.text_log(
        folder / "text.txt", lambda t: f"{t:.4f} ", receiver=SimulatedReceiver(seconds=1, seed=1)
    )
    (folder / "take.xdf").write_bytes(written.WHOLE)
    lines = [f"{n / 500:.4f},{np.sin(n):.5f},{np.cos(n):.5f},9.81" for n in range(600)]
    (folder / "board.log").write_text("\n".join(lines) + "\n")


def cluster(folder: Path) -> None:
    of_set("cluster").write_stroke(folder, "0_135_40_500_0", seconds=0.1)
    write_sound(folder / "sensor_data" / "audio" / "0_135_40_500_0.wav", 3)


def biotac_slide(folder: Path) -> None:
    rows = "".join(f"{i / 100},{','.join(map(str, range(44 * i, 44 * i + 44)))},\n" for i in range(3))
    (folder / "raw_csv").mkdir(parents=True)
    (folder / "raw_csv" / "mat2_9_bio.csv").write_text(
        f"{of_set('biotac_slide').TestBiotacSlide.HEAD}\n{rows}"
    )


def cdplab(folder: Path) -> None:
    of_set("cdplab").write_book(folder / "xlsx" / "wood.xlsx", samples=200)
    write_photo(folder / "images" / "wood.png", 0)


def frictgan(folder: Path) -> None:
    written = module("tactogram-benchmark/tests/frictgan_windows.py")
    place = folder / "train" / "2"
    (place / "output_data").mkdir(parents=True)
    np.savetxt(place / "output_data" / "200.txt", written.amplitudes(written.friction_of(1)))
    write_photo(place / "image" / "200.jpg", 1, rows=8, columns=1024)


def haptex(folder: Path) -> None:
    of_set("haptex").write_stroke(folder / "7" / "trial1.txt", samples=300)
    write_photo(folder / "7" / "photo.jpg", 7, rows=50, columns=50)


def hatt(folder: Path) -> None:
    of_set("hatt").write(folder)


def keio_ultrasonic(folder: Path) -> None:
    rows = [(rater, item, *[4] * 10) for rater in ("p1", "p2") for item in (1, 12)]
    written, rng = of_set("keio_ultrasonic"), np.random.default_rng(0)
    written.table(folder / "plates" / "1" / "m01.csv", rng.standard_normal((300, 4)).round(4))
    written.table(folder / "plates" / "12_m01.csv", np.abs(rng.standard_normal((3, 1000))).round(3))
    written.table(folder / "signals" / "1.csv", np.sin(np.arange(300) / 9)[:, None].round(4))
    for name in ("plates", "signals"):
        written.table(folder / f"{name}.csv", [("rater", "item", *written.WORDS), *rows])


def lmt108(folder: Path) -> None:
    for axis in "XYZ":
        of_set("lmt108").write_lines(
            folder / "AccelScans" / f"G1Mesh_Movement_{axis}_train1.txt", np.sin(range(50))
        )
    write_sound(folder / "SoundScans" / "G1Mesh_Sound_Movement_train1.wav", 1)


def saga_strokes(folder: Path) -> None:
    of_set("saga_strokes").write_take(folder / "ArtGrass01" / "ArtGrass01_03.csv", 1, samples=400)


def vibviz(folder: Path) -> None:
    write_sound(folder / "wav" / "v-1.wav", 1, rate=8000)
    head = of_set("vibviz").TestVibviz.HEAD
    (folder / "vibrationAnnotations-2016.csv").write_text(
        head + 'v-1,11,-2,0.5,-2.6,0.7,-2.5,"simple,soft"\n'
    )


PARTS: dict[str, Callable[[Path], None]] = {
    **{
        made.__name__: made
        for made in (signals, haptic, pictures, waves, recordings, store, other, tables, settings)
    },
    **{made.__name__: made for made in (logs, sweep, packed, session, answers, calibrated)},
    **{
        made.__name__: made
        for made in (biotac_slide, cdplab, cluster, frictgan, haptex, hatt, keio_ultrasonic)
    },
    **{made.__name__: made for made in (lmt108, saga_strokes, vibviz)},
    "names": _run("stroke_statistics"),
    "network": _run("stroke_cnn", recipe="tiny", changes={"config.steps": 3}),
    "textures": _run("ar_texture"),
    "noise": _run("texture_var"),
    "judge": _run("rater"),
}
"""Writers of a folder each."""
NEEDS = dict.fromkeys(("names", "network", "textures", "noise", "judge"), ("store",))
NEEDS |= {"packed": ("names",), "answers": ("session",), "calibrated": ("tables",)}
