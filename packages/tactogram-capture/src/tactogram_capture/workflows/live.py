"""Live recognition: a finished classifier run on a window that slides over a sensor's samples."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.parameters import Positive, checked
from tactogram_capture.catalogue import open_source
from tactogram_capture.source import TappedSource

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun
    from tactogram_capture.live.classifier import LiveClassifier
    from tactogram_capture.live.recognition import WindowClassification
    from tactogram_capture.source import BlockListener


@checked
def live(
    run: Path | str | LoadedRun,
    *,
    source: str,
    window: Positive | None = None,
    hop: Positive | None = None,
    rate: Positive | None = None,
    seconds: Positive | None = None,
    on_window: Callable[[WindowClassification], None] | None = None,
    begin: Callable[[LiveClassifier], None] | None = None,
    heard: BlockListener | None = None,
) -> dict[str, Any]:
    """Classify what a sensor touches, window by window, until it ends, is interrupted, or ``seconds`` are over.

    ``on_window`` receives each window, ``begin`` the classifier before the first. ``heard`` receives the source and
    each block as it is read, see `TappedSource`.

    Parameters
    ----------
    run : Path or str or LoadedRun
        Run of a classifier.
    source : str
        Source of the samples: twelite:/dev/ttyUSB0, serial:PORT, lsl:NAME, audio:NAME, ni:Dev1/ai0:2, digilent:,
        log:FILE, played:STORE.
    window : float, optional
        Length of a window, s (default: the network's input).
    hop : float, optional
        Time from one window to the next, s (default: a quarter of a window).
    rate : float, optional
        The source's rate, Hz, where it states none (default: that of the training data); a measured rate that
        contradicts it is used instead.
    seconds : float, optional
        Stop after this time, s (default: at Ctrl-C).

    Returns
    -------
    dict
        ``windows``, ``judged``, ``skipped``, ``materials`` (windows by likeliest material), ``none_of_these`` (windows,
        or None without a search index), ``latency`` (``p50_ms``, ``p99_ms``, ``max_ms``: from the arrival of a window's
        last sample to its probabilities), ``window_s``, ``hop_s``, ``context_s``, ``threshold``, ``calibrated_on``,
        ``source`` (its facts), ``simulated``, ``interrupted``.

    Raises
    ------
    ParameterError
        If the run is no classifier, or the window is too short for it.
    DeviceError
        If the source cannot be opened, or disappears.
    """
    from tactogram.workflows import load_run
    from tactogram_capture.live.classifier import LiveClassifier
    from tactogram_capture.live.recognition import Latencies, classify_windows
    from tactogram_capture.session.feed import Feed

    loaded = load_run(run) if isinstance(run, Path | str) else run
    classifier = LiveClassifier(loaded, window_s=window)
    hop_s = classifier.window_s / 4 if hop is None else hop
    span_s = classifier.window_s + classifier.context_s
    latencies, named, counts = Latencies(), Counter[str](), Counter[str]()
    interrupted = False
    device = open_source(source)
    with device if heard is None else TappedSource(device, heard) as opened:
        # Where the training recordings were resampled, their rate is not that of their source.
        recorded_rate = loaded.kind.rate if loaded.recipe.prepare.rate == "own" else None
        feed = Feed(opened, reference_rate=rate or opened.rate or recorded_rate)
        if begin is not None:
            begin(classifier)
        try:
            for guess in classify_windows(feed, classifier, window_s=span_s, hop_s=hop_s, seconds=seconds):
                latencies.add(guess)
                counts["windows"] += 1
                counts["skipped"] += guess.skipped
                if guess.classification is not None and guess.material is not None:
                    counts["judged"] += 1
                    counts["none"] += bool(guess.classification.none_of_these)
                    named[guess.material] += 1
                if on_window is not None:
                    on_window(guess)
        except KeyboardInterrupt:
            interrupted = True
        facts = opened.facts()
    return {
        **{name: counts[name] for name in ("windows", "judged", "skipped")},
        "materials": dict(named.most_common()),
        "none_of_these": None if classifier.threshold is None else counts["none"],
        "latency": latencies.facts(),
        "window_s": classifier.window_s,
        "hop_s": hop_s,
        "context_s": classifier.context_s,
        "threshold": classifier.threshold,
        "calibrated_on": classifier.calibrated_on,
        "source": facts,
        "simulated": loaded.simulated or bool(facts.get("simulated")),
        "interrupted": interrupted,
    }
