"""The panel of a live classification."""

from tactogram_capture.cli.live_view import line, panel
from tactogram_capture.live.recognition import Classification, Latencies, classify_windows
from tactogram_capture.session.feed import Feed


def run(source, *, listen=None, clock=None, **options):
    heard = []

    def default(signal):
        heard.append(signal)
        return Classification({"a": 0.25, "b": 0.75}, none_of_these=False)

    clock = clock or (lambda: 0.03 * source.packet)
    feed = Feed(source, clock=clock)
    found = list(
        classify_windows(feed, listen or default, **({"window_s": 1.0, "hop_s": 0.5} | options), clock=clock)
    )
    return found, heard


def test_the_panel_names_the_most_probable_material_or_none_of_these(played):
    from rich.console import Console

    def shown(guess):
        console = Console(width=100, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
        console.print(panel(guess, Latencies([0.01]), title="played:test", unit="m/s^2"))
        console.file.close()
        return console.export_text()

    [known, *_], _ = run(played(packets=40))
    [odd, *_], _ = run(
        played(packets=40), listen=lambda _: Classification({"a": 0.9, "b": 0.1}, none_of_these=True)
    )
    assert "b" in shown(known).splitlines()[1]
    assert "none of these" in shown(odd)
    assert "latency p50 10 ms" in shown(odd)
    assert "none of these?" in line(odd)
