"""A recording: what was measured in one go, and under which conditions."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal


@dataclass(frozen=True, kw_only=True)
class RecordingInfo:
    """Metadata of a recording; None where unknown.

    Parameters
    ----------
    id : str
        Hash of the streams (`content_id`): the same samples are the same recording, wherever met.
    material : str, optional
        What was touched.
    speed_mm_s, force_n, direction_deg : float, optional
        Nominal stroking speed (mm/s), normal force (N), direction of the stroke in the surface (degrees).
    contactor : str, optional
        What touched it, e.g. ``"finger"`` or ``"pen"``.
    session, subject : str, optional
        When and by whom.
    ratings : mapping from str to float
        Scores that people gave.
    labels : mapping from str to str
        Anything else the source says.
    source : str
        Where it came from, as a path relative to the imported folder.
    history : tuple of str
        What was done to get it, in order.
    simulated : bool
        Whether a formula made it.
    """

    id: str = ""
    material: str | None = None
    speed_mm_s: float | None = None
    force_n: float | None = None
    direction_deg: float | None = None
    contactor: str | None = None
    session: str | None = None
    subject: str | None = None
    ratings: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    source: str = ""
    history: tuple[str, ...] = ()
    simulated: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(RecordingInfo):
    """One or more named signals, each at its own rate, and all that is known of them.

    Parameters
    ----------
    streams : mapping from str to Signal
        By name: ``acceleration``, ``force``, ``position``, ``sound``, ``friction``, …
    image : Image, optional
        A photograph of the surface.
    **info
        The fields of `RecordingInfo`; ``id`` follows from the streams when left empty.
    """

    streams: Mapping[str, Signal]
    image: Image | None = None

    def __post_init__(self) -> None:
        if not self.streams:
            raise ParameterError("a recording needs at least one stream, got none")
        if not self.id:
            object.__setattr__(self, "id", content_id(self.streams))

    def stream(self, name: str) -> Signal:
        """Return one stream.

        Raises
        ------
        ParameterError
            If there is none of this name.
        """
        if name not in self.streams:
            raise ParameterError(f"stream must be one of {', '.join(self.streams)}, got {name!r}")
        return self.streams[name]

    @property
    def info(self) -> RecordingInfo:
        """The same without samples and image."""
        return RecordingInfo(**{f.name: getattr(self, f.name) for f in fields(RecordingInfo)})


def content_id(streams: Mapping[str, Signal]) -> str:
    """Return 16 hex digits that follow from the names, rates, units, axes and samples of ``streams``."""
    digest = hashlib.sha256()
    for name in sorted(streams):
        s = streams[name]
        digest.update(f"{name}|{s.rate!r}|{s.unit}|{','.join(s.axes)}|{s.domain}|{len(s)}|".encode())
        digest.update(s.samples.astype("<f4", copy=False).tobytes())
    return digest.hexdigest()[:16]
