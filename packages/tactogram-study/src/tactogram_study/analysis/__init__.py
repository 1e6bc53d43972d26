"""Methods of analysis that designs share: findings with intervals and verdicts, and the tests behind them."""
