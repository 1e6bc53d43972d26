"""A simulated transducer over time: what of a drive arrives at the horn, exactly, and the current that tells of it.

Two ways to the same. `TransducerSimulation` solves the circuit in a frame that turns with the carrier: only envelopes
are sampled (at some 10 kHz), nothing is averaged over a carrier's period, and carrier and resonance may move while it
runs. `simulate_waveform` solves it at the rate of a rendered waveform (some 100 kHz), and `demodulated` finds the
envelope again.

What arrives is given as motional current times R1, in V: at resonance, once settled, that is the drive's own amplitude.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import signal as dsp

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.transducer.circuit import Transducer
from tactogram.signal.filters import butterworth
from tactogram.signal.signal import Signal


class TransducerSimulation:
    """A simulated transducer with state, driven by blocks of an envelope.

    How an envelope is cut into blocks changes nothing. Between two samples it is taken as a straight line.

    Parameters
    ----------
    transducer : Transducer
    rate : float, Hz
        Of the envelope.
    carrier_hz : float
        > 0.

    Notes
    -----
    States are the motional current i and the voltage u over C1, as complex amplitudes: L1 i' = V - R1 i - u,
    C1 u' = i, less j w of each. The matrix is diagonalised, and each mode is a recursion that is exact for a straight
    line between samples.
    """

    def __init__(self, transducer: Transducer, *, rate: float, carrier_hz: float) -> None:
        if not (rate > 0 and np.isfinite(rate)):
            raise ParameterError(f"rate must be > 0 Hz, got {rate}")
        self.rate = float(rate)
        self._state: NDArray[np.complex128] = np.zeros(2, np.complex128)
        self._last: complex = 0j
        self.change(transducer=transducer, carrier_hz=carrier_hz)

    def change(self, *, transducer: Transducer | None = None, carrier_hz: float | None = None) -> None:
        """Go on with another transducer (its resonance has drifted, a finger came) or another carrier.

        Currents and voltages do not jump; neither does the carrier's phase.
        """
        if transducer is not None:
            self.transducer = transducer
        if carrier_hz is not None:
            if not (carrier_hz > 0 and np.isfinite(carrier_hz)):
                raise ParameterError(f"carrier_hz must be > 0, got {carrier_hz}")
            self.carrier_hz = float(carrier_hz)
        t, w = self.transducer, 2 * np.pi * self.carrier_hz
        matrix = np.array(
            [[-t.r1_ohm / t.l1_henry - 1j * w, -1 / t.l1_henry], [1 / t.c1_farad, -1j * w]], np.complex128
        )
        self._modes, self._basis = np.linalg.eig(matrix)
        self._drive = np.linalg.solve(self._basis, np.array([1 / t.l1_henry, 0], np.complex128))

    def process(self, envelope: ArrayLike) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the next block's currents.

        Parameters
        ----------
        envelope : real or complex array, shape (time,), V
            Amplitude of the carrier; not empty.

        Returns
        -------
        motional, whole : complex128 arrays, shape (time,), A
            Amplitudes of the motional current, and of the whole (C0's included), at the samples of ``envelope``.
        """
        v = np.atleast_1d(np.asarray(envelope, np.complex128))
        before = np.concatenate([[self._last], v[:-1]])
        step = 1 / self.rate
        parts = []
        inside = np.linalg.solve(self._basis, self._state)
        for mode, gain, start in zip(self._modes, self._drive, inside, strict=True):
            a = mode * step
            grown = np.exp(a)
            second = (grown - 1 - a) / a**2
            first = (grown - 1) / a - second
            b = gain * step * np.array([second, first])
            begin = b[1] * self._last + grown * start
            part, _ = dsp.lfilter(b, [1, -grown], v, zi=[begin - 0j])
            parts.append(part)
        states = self._basis @ np.array(parts)  # 2, time
        self._state, self._last = states[:, -1], complex(v[-1])
        w = 2 * np.pi * self.carrier_hz
        c0 = self.transducer.c0_farad
        return states[0], states[0] + c0 * ((v - before) * self.rate + 1j * w * v)


def simulate_envelope(transducer: Transducer, envelope: Signal, *, carrier_hz: float | None = None) -> Signal:
    """Return what of an envelope arrives at a simulated transducer that was at rest.

    Parameters
    ----------
    transducer : Transducer
    envelope : Signal
        One axis, V: amplitude of the carrier.
    carrier_hz : float, optional
        By default the transducer's resonance.

    Returns
    -------
    Signal
        Magnitude of the motional current times R1, V; same rate and length.
    """
    _volts(envelope)
    carrier = transducer.resonance_hz if carrier_hz is None else carrier_hz
    simulated = TransducerSimulation(transducer, rate=envelope.rate, carrier_hz=carrier)
    motional, _ = simulated.process(envelope.samples[0])
    return envelope.with_samples(np.abs(motional) * transducer.r1_ohm)


def simulate_waveform(transducer: Transducer, drive: Signal) -> Signal:
    """Return the motional current times R1, V, of a simulated transducer at rest to which a waveform is given.

    Between two samples the drive is a straight line, as after a converter's filter; at 500 kHz a 28.2 kHz carrier
    loses 1 % by that.

    Parameters
    ----------
    transducer : Transducer
    drive : Signal
        One axis, V, carrier and all; at ten times the resonance or more.

    Raises
    ------
    ParameterError
        If the rate is too low for the carrier.
    """
    _volts(drive)
    if drive.rate < 8 * transducer.resonance_hz:
        raise ParameterError(
            f"a waveform for {transducer.resonance_hz:g} Hz is simulated from {8 * transducer.resonance_hz:g} Hz on, "
            f"got {drive.rate:g}; simulate its envelope instead"
        )
    t = transducer
    a = np.array([[-t.r1_ohm / t.l1_henry, -1 / t.l1_henry], [1 / t.c1_farad, 0]])
    system = (a, np.array([[1 / t.l1_henry], [0]]), np.array([[t.r1_ohm, 0]]), np.zeros((1, 1)))
    *discrete, _ = dsp.cont2discrete(system, 1 / drive.rate, method="foh")
    numerator, denominator = dsp.ss2tf(*discrete)
    return drive.with_samples(dsp.lfilter(numerator[0], denominator, drive.samples[0].astype(np.float64)))


def demodulated(waveform: Signal, *, carrier_hz: float, band_hz: float) -> Signal:
    """Return the envelope of a modulated carrier: turned down to 0 Hz, low-pass, magnitude.

    Parameters
    ----------
    waveform : Signal
        One axis, over time.
    carrier_hz : float
    band_hz : float
        What of the envelope is kept; below ``carrier_hz``.

    Returns
    -------
    Signal
        >= 0, same rate, unit and length; without delay, the ends mirrored.

    Raises
    ------
    ParameterError
        If the band reaches the carrier, or the rate is too low for it.
    """
    if len(waveform.axes) != 1 or waveform.domain != "time":
        raise ParameterError(
            f"a waveform is one axis over time, got {len(waveform.axes)} over {waveform.domain}"
        )
    if not 0 < band_hz < carrier_hz < waveform.rate / 2:
        raise ParameterError(
            f"needs 0 < band < carrier < half the rate, got {band_hz:g}, {carrier_hz:g} and {waveform.rate / 2:g} Hz"
        )
    turned = (
        2 * waveform.samples[0] * np.exp(-2j * np.pi * carrier_hz * np.arange(len(waveform)) / waveform.rate)
    )
    sos = butterworth(waveform.rate, 0, band_hz, passes=2)
    pad = min(len(waveform) - 1, int(3 * waveform.rate / band_hz))
    slow = [
        dsp.sosfiltfilt(sos, part, padtype="even" if pad else None, padlen=pad)
        for part in (turned.real, turned.imag)
    ]
    return waveform.with_samples(np.hypot(*slow))


def lock_in(
    voltage: ArrayLike, current: ArrayLike, *, rate: float, frequency_hz: float, settling: int = 0
) -> complex:
    """Return the admittance at ``frequency_hz``, S, from measured samples of voltage and current.

    Parameters
    ----------
    voltage, current : float arrays, shape (time,), V and A
        Taken at the same instants. The last whole number of periods is used.
    rate : float, Hz
    frequency_hz : float
    settling : int
        Samples left out at the beginning.

    Raises
    ------
    ParameterError
        If no whole period is left, or there is no voltage at that frequency.
    """
    v, i = np.asarray(voltage, np.float64)[settling:], np.asarray(current, np.float64)[settling:]
    if v.ndim != 1 or v.shape != i.shape:
        raise ParameterError(f"voltage and current must be equally long, got {v.shape} and {i.shape}")
    count = int(int(len(v) * frequency_hz / rate) * rate / frequency_hz)
    if count < 2:
        raise ParameterError(f"needs a whole period of {frequency_hz:g} Hz, got {len(v) / rate:g} s")
    turn = np.exp(-2j * np.pi * frequency_hz * np.arange(count) / rate) * np.hanning(count)
    volts = v[-count:] @ turn
    if abs(volts) <= 1e-9 * float(np.abs(v[-count:]).sum() + 1e-300):
        raise ParameterError(f"no voltage at {frequency_hz:g} Hz: the drive is off or at another frequency")
    return complex((i[-count:] @ turn) / volts)


def _volts(signal: Signal) -> None:
    if signal.unit != "V":
        raise UnitError(f"a transducer is driven by V, got {signal.unit}")
    if len(signal.axes) != 1 or signal.domain != "time":
        raise ParameterError(f"a drive is one axis over time, got {len(signal.axes)} over {signal.domain}")
