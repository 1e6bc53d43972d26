"""Digilent Analog Discovery as generator of a modulated carrier, of which only the envelope is sent to the device.

Its AM node multiplies the carrier by 1 + (percent / 100) x data, with data from -1 to 1 (Digilent's own example: a
carrier of 1 V at 100 % gives 0 to 2 V). The carrier is therefore set to half of the largest voltage, and an envelope e
becomes e / carrier - 1: no data can exceed the largest voltage. A waveform of 28 kHz would not fit the device's
buffer.

Tested against a simulated device with dwfpy's calls only. Unknown about a real one: whether its AM node streams. If it
does not, `AnalogDiscovery.play` refuses and `AnalogDiscovery.loop` remains.
"""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import DeviceError, ParameterError, UnitError
from tactogram.extras import device_errors, imported
from tactogram.rendering import CarrierSettings
from tactogram.signal import Signal
from tactogram.validation import FrozenModel, validated

LARGEST_V = 5.0
"""Largest voltage of an Analog Discovery's generator, 0 to peak."""
PREFILL_S = 0.05
MARGIN_S = 1.0
"""The device stops by itself this long after the planned end, even if this program was killed."""
POLL_S = 0.002
STALLED_S = 2.0
"""A device without free buffer for this long counts as gone."""
OFF = -1.0
"""Data of the AM node that turn the carrier off."""


class GeneratorSettings(FrozenModel):
    """Settings of the generator."""

    carrier_hz: float = Field(gt=0, le=1e6)
    peak_v: float = Field(gt=0, le=LARGEST_V)
    """Largest voltage of the generator, 0 to peak; the transducer gets this times the amplifier's gain."""
    channel: int = Field(default=1, ge=1, le=2)
    """As labelled on the device."""
    serial: str = ""
    """Serial number; empty for the first device."""


def generator(settings: CarrierSettings, *, channel: int = 1, serial: str = "") -> GeneratorSettings:
    """Return the generator settings for a display.

    Raises `ParameterError` if they exceed the device's voltage.
    """
    if settings.peak_v > LARGEST_V:
        raise ParameterError(
            f"the device supplies at most {LARGEST_V:g} V, but the settings allow {settings.peak_v:g} V at the "
            "generator: set amplifier_gain"
        )
    values = {
        "carrier_hz": settings.carrier_hz,
        "peak_v": settings.peak_v,
        "channel": channel,
        "serial": serial,
    }
    return validated(GeneratorSettings, values, where="digilent")


def am_data(envelope: NDArray[np.floating], peak_v: float) -> NDArray[np.float64]:
    """Return the AM node's data for an envelope of 0 to ``peak_v`` (float array, shape (time,), V): e / (peak / 2) - 1.

    float64, same shape, -1 to 1; NaN becomes 0 V, values outside are clipped.
    """
    volts = np.nan_to_num(np.asarray(envelope, np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.clip(2 * volts / peak_v - 1, -1.0, 1.0))


class AnalogDiscovery:
    """An Analog Discovery whose carrier is modulated by envelopes; a context manager that leaves it at 0 V.

    In tests, ``module`` replaces dwfpy, and ``sleep`` and ``clock`` replace those of `time`.
    """

    simulated = False

    def __init__(
        self,
        wanted: GeneratorSettings,
        *,
        module: Any = None,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.wanted = wanted
        self.name = f"digilent:{wanted.serial or 'first'}"
        self.lost = self.corrupted = self.sent = 0
        self._module, self._sleep, self._clock = module, sleep, clock
        self._device: Any = None
        self._channel: Any = None
        self._node: Any = None

    def __enter__(self) -> Self:
        """Open the device and set its carrier, silent.

        Raises `MissingExtraError` or `DeviceError` if dwfpy or WaveForms is not installed, or there is no such
        device, generator or AM node.
        """
        if self._module is None:
            self._module = imported("dwfpy", extra="dwf", what="Digilent devices")
        with device_errors(self.name, library="dwfpy"):
            device = self._module.Device(serial_number=self.wanted.serial or None)
            device.open()
            self._device = device
            try:
                self._set_up(device)
            except BaseException:
                self.close()
                raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Set the generator to 0 V and close the device, whatever happened before."""
        device, self._device = self._device, None
        if device is None:
            return
        try:
            self._silence()
        finally:
            self._channel = self._node = None
            with suppress(Exception):
                device.close()

    def play(
        self,
        envelope: Signal | Iterator[NDArray[np.floating]],
        *,
        rate: float | None = None,
        longest_s: float = 600.0,
    ) -> None:
        """Send an envelope as fast as the device accepts it, and return at 0 V when all of it was played.

        ``envelope`` is the amplitude of the carrier from 0 to ``peak_v``: a Signal, or blocks (float arrays, shape
        (time,), V) with their ``rate`` in Hz, which the device stops after ``longest_s``. Raises `DeviceError` if the
        device cannot stream its AM node, stalls or is gone; it is at 0 V then, if it still responds.
        """
        self._opened()
        blocks, rate = _blocks(envelope, rate)
        functions = self._module.Function
        if functions.PLAY not in self._node.function_info:
            raise DeviceError(
                f"{self.name}: its AM node does not stream; play a loop that fits its buffer instead"
            )
        prefill = np.full(max(2, int(PREFILL_S * rate)), OFF)
        # As many as the buffer holds: once they are in it, all that was sent before them has come out.
        silence = np.full(max(len(prefill), int(self._node.data_samples_max)), OFF)
        seconds = envelope.seconds if isinstance(envelope, Signal) else longest_s
        try:
            with device_errors(self.name, library="dwfpy"):
                length = seconds + (2 * len(prefill) + len(silence)) / rate + MARGIN_S
                self._start(length, "play", frequency=rate, data_samples=prefill.tolist())
                for block in blocks:
                    self._send(am_data(block, self.wanted.peak_v))
                self._send(silence)
                self._sleep(len(prefill) / rate)
        finally:
            self._silence()

    def loop(self, envelope: Signal, seconds: float) -> None:
        """Repeat one period of an envelope from the device's buffer for ``seconds``, then go to 0 V.

        Raises `ParameterError` if the period does not fit the buffer, or ``seconds`` is not > 0: the device takes 0
        as endless; `DeviceError` if the device is gone.
        """
        self._opened()
        if not (math.isfinite(seconds) and seconds > 0):
            raise ParameterError(f"a loop's length must be > 0 s, got {seconds:g}")
        (data,), rate = _blocks(envelope, None)
        buffer = int(self._node.data_samples_max)
        if len(data) > buffer:
            raise ParameterError(
                f"{self.name}: a loop of {len(data)} samples does not fit its buffer of {buffer}: lower the rate to "
                f"{buffer / envelope.seconds:.0f} Hz or less"
            )
        try:
            with device_errors(self.name, library="dwfpy"):
                samples = am_data(data, self.wanted.peak_v).tolist()
                self._start(seconds, "custom", frequency=rate / len(data), data_samples=samples)
                self._sleep(seconds)
                self.sent += round(seconds * rate)
        finally:
            self._silence()

    def hold(self, amplitude_v: float, *, longest_s: float) -> None:
        """Start the unmodulated carrier at ``amplitude_v`` (0 to peak), until `close` but at most for ``longest_s``.

        Raises `ParameterError` if either is out of range (the device takes 0 s as endless); `DeviceError` if it is
        gone.
        """
        self._opened()
        if not 0 <= amplitude_v <= self.wanted.peak_v:
            raise ParameterError.must("amplitude_v", f"be 0 to {self.wanted.peak_v:g} V", amplitude_v)
        if not (math.isfinite(longest_s) and longest_s > 0):
            raise ParameterError.must("longest_s", "be > 0 s", longest_s)
        data = float(am_data(np.array([amplitude_v]), self.wanted.peak_v)[0])
        try:
            with device_errors(self.name, library="dwfpy"):
                self._start(longest_s, "dc", offset=100 * data, enabled=True)
        except BaseException:
            self._silence()
            raise

    @property
    def opened_device(self) -> tuple[Any, Any]:
        """Dwfpy's device and dwfpy itself, for `admittance.DigilentRecorder`."""
        self._opened()
        return self._device, self._module

    def retune(self, carrier_hz: float) -> None:
        """Change the carrier's frequency, for resonance tracking; its amplitude and the envelope continue."""
        self._opened()
        values = {**self.wanted.model_dump(), "carrier_hz": carrier_hz}
        self.wanted = validated(GeneratorSettings, values, where=self.name)
        with device_errors(self.name, library="dwfpy"):
            self._channel[self._module.AnalogOutputNode.CARRIER].frequency = carrier_hz
            self._channel.apply()

    def facts(self) -> dict[str, Any]:
        """Return what was sent and lost, as JSON values."""
        return {
            "device": self.name,
            "simulated": self.simulated,
            "carrier_hz": self.wanted.carrier_hz,
            "peak_v": self.wanted.peak_v,
            "sent_samples": self.sent,
            "lost_samples": self.lost,
            "corrupted_samples": self.corrupted,
        }

    def _set_up(self, device: Any) -> None:
        nodes, channels = self._module.AnalogOutputNode, device.analog_output.channels
        if self.wanted.channel > len(channels):
            raise DeviceError(f"{self.name}: has no generator {self.wanted.channel}, only {len(channels)}")
        self._channel = channels[self.wanted.channel - 1]
        if not {nodes.CARRIER, nodes.AM} <= {node.type for node in self._channel.nodes}:
            raise DeviceError(f"{self.name}: generator {self.wanted.channel} has no AM node")
        self._node = self._channel[nodes.AM]
        self._channel.reset()
        self._channel.idle = self._module.AnalogOutputIdle.OFFSET
        self._channel.setup_am(function="dc", amplitude=100.0, offset=-100.0, enabled=True)
        self._carrier(on=False)

    def _start(self, seconds: float, function: str, *, offset: float = 0.0, **am: Any) -> None:
        """Start the modulated carrier, which the device stops by itself after ``seconds``."""
        self._channel.setup_am(function=function, amplitude=100.0, offset=offset, **am)
        self._channel.run_length = seconds
        self._carrier(on=True)
        self._channel.configure(start=True)

    def _carrier(self, *, on: bool) -> None:
        self._channel.setup(
            function="sine",
            frequency=self.wanted.carrier_hz,
            amplitude=self.wanted.peak_v / 2 if on else 0.0,
            offset=0.0,
        )

    def _send(self, data: NDArray[np.float64]) -> None:
        done, since = 0, self._clock()
        while done < len(data):
            if self._channel.read_status() == self._module.Status.DONE:
                raise DeviceError(f"{self.name}: reached its time limit and stopped by itself")
            free, lost, corrupted = self._node.play_status
            self.lost += lost
            self.corrupted += corrupted
            count = min(free, len(data) - done)
            if count <= 0:
                if self._clock() - since > STALLED_S:
                    raise DeviceError(
                        f"{self.name}: accepted no samples for {STALLED_S:g} s and was silenced"
                    )
                self._sleep(POLL_S)
                continue
            # dwfpy passes this on unchanged: it must be an array of doubles.
            piece = (ctypes.c_double * count)(*data[done : done + count])
            self._node.set_play_samples(piece)
            done += count
            self.sent += count
            since = self._clock()

    def _silence(self) -> None:
        """Set the carrier's amplitude to 0 and stop; each step on its own, since one may fail."""
        channel = self._channel
        if channel is None:
            return
        for act in (lambda: self._carrier(on=False), channel.apply, lambda: channel.configure(start=False)):
            with suppress(Exception):
                act()

    def _opened(self) -> None:
        if self._device is None:
            raise DeviceError(f"{self.name}: is not open")


def _blocks(
    envelope: Signal | Iterator[NDArray[np.floating]], rate: float | None
) -> tuple[Iterator[NDArray[np.floating]] | list[NDArray[np.floating]], float]:
    if isinstance(envelope, Signal):
        if envelope.unit != "V":
            raise UnitError(f"an envelope must be in V, got {envelope.unit}")
        if len(envelope.axes) != 1 or envelope.domain != "time" or float(envelope.samples.min()) < 0:
            raise ParameterError(
                "an envelope must be one axis over time and never below 0 V: render with output = 'envelope'"
            )
        return [envelope.samples[0]], envelope.rate
    if rate is None or not rate > 0:
        raise ParameterError(f"blocks need a rate > 0 Hz, got {rate}")
    return envelope, rate
