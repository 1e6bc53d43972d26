"""Figure of the trade-off."""

from tactogram_benchmark.experiments.trade_off import TradeOff, trade_off_figure


def test_the_trade_off_names_every_weight():
    weights = [
        TradeOff(f"weight {w:,}", [r], [d], [0.5], [0.2]) for w, r, d in ((1, 0.6, 90.0), (1000, 0.3, 50.0))
    ]
    figure = trade_off_figure(weights, distance="FID", best=0.9)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {"weight 1", "weight 1,000"} <= set(texts)
    assert "FID" in figure.axes[0].get_xlabel()
