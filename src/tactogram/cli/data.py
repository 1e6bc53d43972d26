"""Verbs on data sets: import, simulate, inspect, check, extend, rate."""

from __future__ import annotations

from tactogram.cli.options import Add, Verbs, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, columns, lines_of, print_result, ratings_text, shortened
from tactogram.errors import ParameterError


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    verbs = verbs.group("data", "import, simulate, inspect and check data sets")
    verbs.add("list", data_list)
    _import_options(verbs.add("import", data_import))
    _simulate_options(verbs.add("simulate", data_simulate))
    for name, function in (("info", data_info), ("check", data_check), ("compact", data_compact)):
        verbs.add(name, function)("path", metavar="DIR")
    _add_options(verbs.add("add", data_add))
    _like_options(verbs.add("like", data_like))
    _rate_options(verbs.add("rate", data_rate))
    _ratings_options(verbs.add("ratings", data_ratings))


def data_list(a: Arguments) -> None:
    """List what can be imported and simulated."""
    from tactogram.workflows.data.stores import list_sets

    facts = list_sets()
    rows = [(name, s["title"], s["licence"]) for name, s in facts["import"].items()]
    text = "import:\n" + columns(rows)
    text += "\nsimulate:\n" + columns(list(facts["simulate"].items()))
    print_result(a, facts, text)


def data_import(a: Arguments) -> None:
    """Import a data set into a store."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.data.stores import import_store
    from tactogram.workflows.progress import shown

    options = parse_changes(a.options)
    with shown() as progress:
        report = import_store(
            a.set,
            a.path,
            a.out,
            options=options,
            skip_bad=a.skip_bad,
            workers=a.workers,
            progress=progress,
        )
    print_result(a, report, lines_of(report))


def data_simulate(a: Arguments) -> None:
    """Simulate a data set of surfaces."""
    from tactogram.workflows.data.simulate import simulate_to_store
    from tactogram.workflows.progress import shown

    options = {
        "per_class": a.per_class,
        "rate": a.rate,
        "seconds": a.seconds,
        "speeds_mm_s": None if a.speeds is None else _speeds(a.speeds),
        "raters": a.raters,
        "workers": a.workers,
    }
    if a.photographs is not None:
        options["photographs"] = a.photographs
    with shown() as progress:
        report = simulate_to_store(a.set, a.out, seed=a.seed, progress=progress, **options)
    print_result(a, report, lines_of(report))


def _speeds(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"speeds must be numbers separated by commas, such as 50,100,200; got {text}"
        ) from None


def data_info(a: Arguments) -> None:
    """Describe what a store holds."""
    from tactogram.workflows.data.stores import store_info

    facts = store_info(a.path)
    ratings = facts["ratings"]
    text = lines_of({name: shortened(value) for name, value in facts.items() if name != "ratings"})
    print_result(a, facts, text if ratings is None else f"{text}\n{ratings_text(ratings)}")


def data_ratings(a: Arguments) -> None:
    """Write the ratings of a store as a table."""
    from tactogram.workflows.data.rating_tables import export_ratings

    facts = export_ratings(a.path, a.out, form="wide" if a.wide else "long")
    print_result(a, facts, lines_of(facts))


def data_check(a: Arguments) -> int:
    """Check every shard of a store against its hash."""
    from tactogram.workflows.data.stores import check_store

    facts = check_store(a.path)
    print_result(a, facts, lines_of(facts))
    return 0 if facts["ok"] else 1


def data_compact(a: Arguments) -> None:
    """Merge the small shards of a store, one per take of a session, into few large ones."""
    from tactogram.workflows.data.stores import compact_store
    from tactogram.workflows.progress import shown

    with shown() as progress:
        facts = compact_store(a.path, progress=progress)
    print_result(a, facts, lines_of(facts))


def data_add(a: Arguments) -> None:
    """Add a recording to a store."""
    from tactogram.workflows.data.stores import add_signal

    facts = add_signal(
        a.path,
        a.file,
        material=a.material,
        stream=a.stream,
        speed_mm_s=a.speed,
        force_n=a.force,
        contactor=a.contactor,
        session=a.session,
        subject=a.subject,
        photograph=a.photograph,
        simulated=a.simulated,
        **signal_arguments(a),
    )
    print_result(a, facts, lines_of(facts))


def data_like(a: Arguments) -> None:
    """Find the recordings of a store whose spectra are nearest to a file's, without a trained run."""
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.spectral_search import find_similar

    facts = find_similar(a.path, read_signal(a.file, **signal_arguments(a)), stream=a.stream, count=a.count)
    rows = [(f["material"] or "", f"{f['distance']:.2f} dB", f["id"]) for f in facts["nearest"]]
    print_result(a, facts, facts["measure"] + "\n" + columns(rows))


def data_rate(a: Arguments) -> None:
    """Add tables of ratings to a store."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.data.rating_tables import rate_store

    facts = rate_store(a.path, a.files, scale=a.scale, settings=parse_changes(a.options), replace=a.replace)
    print_result(a, facts, lines_of({name: shortened(value) for name, value in facts.items()}))


def _import_options(add: Add) -> None:
    add("set", metavar="SET", help="one of `tactogram data list`; `folder` for MATERIAL/*.wav and the like")
    add("path", metavar="PATH")
    add("--out", required=True, metavar="DIR")
    add("--skip-bad", action="store_true", help="report broken files and continue without them")
    add(
        "--set",
        dest="options",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="what the files do not state, e.g. rate=1000",
    )
    add("--workers", type=int, help="processes (default: all cores)")


def _simulate_options(add: Add) -> None:
    add("set", metavar="SET")
    add("--out", required=True, metavar="DIR")
    add("--seed", type=int, default=0)
    add("--per-class", type=int, metavar="N", help="recordings per class")
    add("--rate", type=float, metavar="HZ")
    add("--seconds", type=float, help="length of a recording")
    add("--speeds", metavar="MM_S,MM_S,...", help="stroking speeds (default: the paper's)")
    add(
        "--photographs",
        type=int,
        metavar="N",
        help="photographs of each surface, up to 9 places (default: one picture)",
    )
    add(
        "--raters",
        type=int,
        metavar="N",
        help="simulated raters, in sets with ratings (default: the paper's)",
    )
    add("--workers", type=int, help="processes (default: all cores)")


def _add_options(add: Add) -> None:
    add("path", metavar="DIR")
    add("file", metavar="FILE")
    add("--material", required=True, metavar="NAME")
    add("--stream", default=None, help="name of the stream (default: the store's only one)")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    for name, text in (
        ("contactor", "what touched the surface"),
        ("session", "name of the session"),
        ("subject", "who stroked, as a code"),
    ):
        add(f"--{name}", metavar="NAME", help=text)
    add("--photograph", metavar="FILE", help="photograph of the surface")
    add("--simulated", action="store_true", help="the signal was computed, not measured")
    signal_options(add)


def _like_options(add: Add) -> None:
    add("path", metavar="DIR")
    add("file", metavar="FILE")
    add("--stream", default=None, help="stream to search (default: as in training)")
    add("--count", type=int, default=5, help="number of results (default %(default)s)")
    signal_options(add)


def _rate_options(add: Add) -> None:
    add("path", metavar="DIR")
    add(
        "files",
        metavar="FILE",
        nargs="+",
        help=".csv, .tsv or .parquet: a row per score, or a column per word",
    )
    add(
        "--scale",
        default="7-point",
        help="7-point, evoked, LOW:HIGH or LOW:HIGH:STEP (default %(default)s)",
    )
    add("--replace", action="store_true", help="replace existing ratings")
    add(
        "--set",
        dest="options",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="column.rater=HEADING (or item, word, score, order, session, a word), words=A,B, ignore=A,B, "
        "item=plate{:0>2}, encoding=cp932",
    )


def _ratings_options(add: Add) -> None:
    add("path", metavar="DIR")
    add("--out", required=True, metavar="FILE", help=".csv, .tsv or .parquet")
    add(
        "--wide",
        action="store_true",
        help="one row per rater and item and one column per word, instead of one row per score",
    )
