"""The verbs of tactogram-benchmark; imports nothing heavy."""

GROUPS = {
    "benchmark": "answer fixed tasks with models, and rank them",
}
VERBS = {
    "benchmarking": {
        "benchmark list": "List the tasks, and whether their data is at hand.",
        "benchmark run": "Train models for tasks, answer them, and write a result per model, task and seed.",
        "benchmark table": "Rank the models of every task from results.",
        "benchmark check": "Check the file of a result.",
        "benchmark questions": "Write the training data and questions of a task as files for any framework.",
        "benchmark score": "Score answers from files.",
        "reproduce": "Run the experiment behind a published table or figure.",
        "table": "Show every model's published results and ours, and the figures of evaluated runs.",
    },
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
