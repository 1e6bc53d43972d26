"""
A study from its design to its report
=====================================

How many participants are needed, what the analysis will look like, and whether it finds what is there: *simulated*
participants take a study before people do.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.power import study_power
from tactogram_study.workflows.sessions import simulate_study

folder = Path(mkdtemp())

# %%
# Two areas: which one is generated? How many people are needed to show that they cannot tell.
power = study_power("two-area")
print(power["text"])

# %%
# Twelve simulated participants who can tell a little.
session = folder / "session"
simulate_study("two-area", session, participants=12, effect={"d_prime": 0.8}, seed=1)

# %%
# The analysis that was planned in the study's file, with its figures; ``report.html`` shows it all.
result = analyse_study(session, folder / "analysis")
print(result["text"])
for name in result["files"]:
    if name.endswith(".png"):
        plt.figure(figsize=(8, 5))
        plt.imshow(plt.imread(folder / "analysis" / name))
        plt.axis("off")
plt.show()
