"""
Simulated surfaces, stroked
===========================

Height fields, the photographs rendered from them, and what an accelerometer on the finger says. Simulated throughout.
"""

from pathlib import Path

from tactogram.datasets.simulate import make, tasks
from tactogram.evaluation.figures import photos_figure, signal_figure
from tactogram.evaluation.report import save_figure

recordings = [make(task) for task in tasks("stroking9", seed=0, per_class=1, seconds=2)]
for recording in recordings:
    acceleration = recording.stream("acceleration")
    print(
        f"{recording.material:22} {acceleration.samples.std(axis=1).round(2)} m/s^2 rms about the mean, simulated"
    )

save_figure(Path("surfaces.png"), photos_figure({str(r.material): r.image for r in recordings}))
save_figure(
    Path("stroke.png"), signal_figure(recordings[2].stream("acceleration"), title="carpet (simulated)")
)
