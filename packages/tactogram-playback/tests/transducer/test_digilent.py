import sys
from enum import IntEnum

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import DeviceError, MissingExtraError, ParameterError, UnitError
from tactogram.rendering.drive.electrovibration import Settings as ElectrovibrationSettings
from tactogram.rendering.families.ultrasonic import Settings, modulated
from tactogram.signal import Signal
from tactogram_playback.transducer.admittance import (
    DigilentRecorder,
    MeasuredAdmittance,
    ProbeSettings,
    ScopeSettings,
)
from tactogram_playback.transducer.digilent import AnalogDiscovery, GeneratorSettings, am_data, generator


class AnalogOutputNode(IntEnum):
    CARRIER = 0
    FM = 1
    AM = 2


class Function(IntEnum):
    SINE = 1
    CUSTOM = 30
    PLAY = 31


class AnalogOutputIdle(IntEnum):
    OFFSET = 1


class Status(IntEnum):
    DONE = 2
    RUNNING = 3


class SimulatedNode:
    def __init__(self, kind, channel, functions):
        self.type, self.channel, self.function_info = kind, channel, functions
        self.function, self.frequency, self.amplitude, self.offset, self.data = "dc", 0.0, 0.0, 0.0, [0.0]
        self.data_samples_max = 16_384
        self.buffer = []

    @property
    def play_status(self):
        if self.channel.device.gone:
            raise OSError("device not found")
        return self.channel.free, self.channel.loses, 0

    def set_play_samples(self, samples):
        assert samples._type_.__name__ == "c_double"
        self.channel.played += list(samples)


class SimulatedChannel:
    """An Analog Discovery's documented response to dwfpy's calls; output in V."""

    def __init__(self, device, functions):
        self.device, self.free, self.loses, self.running = device, 256, 0, False
        self.nodes = [SimulatedNode(kind, self, functions) for kind in AnalogOutputNode]
        self.played, self.peaks, self.run_length = [], [], 0.0

    def __getitem__(self, kind):
        return self.nodes[kind]

    def setup(self, **values):
        self._set(AnalogOutputNode.CARRIER, values)

    def setup_am(self, *, enabled=True, data_samples=None, **values):
        if data_samples is not None:
            self.nodes[AnalogOutputNode.AM].data = data_samples
            if values.get("function") == "play":
                self.played += data_samples
        self._set(AnalogOutputNode.AM, values)

    def _set(self, kind, values):
        for name, value in values.items():
            setattr(self.nodes[kind], name, value)

    def configure(self, start=False):
        self.running = bool(start)

    def apply(self):
        pass

    def reset(self):
        self.running = False

    def read_status(self):
        over = self.run_length and len(self.played) / self.nodes[2].frequency > self.run_length
        return Status.DONE if over else Status.RUNNING

    def output(self, data):
        am = self.nodes[AnalogOutputNode.AM]
        return self.nodes[0].amplitude * (1 + am.amplitude / 100 * np.asarray(data) + am.offset / 100)


class SimulatedDwf:
    """Replaces the module dwfpy."""

    AnalogOutputNode, Function = AnalogOutputNode, Function
    AnalogOutputIdle, Status = AnalogOutputIdle, Status

    def __init__(self, *, functions=tuple(Function), channels=2):
        self.gone = self.closed = False
        self.channels = [SimulatedChannel(self, functions) for _ in range(channels)]
        self.analog_output = self

    def Device(self, serial_number=None):  # noqa: N802
        self.serial_number = serial_number
        return self

    def open(self):
        if self.serial_number == "missing":
            raise RuntimeError("No devices match the filter")

    def close(self):
        self.closed = True


class SimulatedInput:
    range = 50.0

    def __init__(self, scope, place):
        self.scope, self.place = scope, place

    def get_data(self, first, count):
        carrier = self.scope.generator.nodes[0]
        t = np.arange(count) / self.scope.frequency
        size = carrier.amplitude * (1 + self.scope.generator.nodes[2].offset / 100)
        return size * (1.0, 0.02)[self.place] * np.sin(2 * np.pi * carrier.frequency * t)


class SimulatedScope:
    """Inputs that see the generator itself, and a fiftieth of it over the shunt."""

    buffer_size_max = 8192

    def __init__(self, generator):
        self.generator, self.frequency, self.polls = generator, 0.0, 0
        self.channels = [SimulatedInput(self, place) for place in range(2)]

    def setup_channel(self, channel, *, range, **values):
        self.channels[channel].range = range

    def setup_acquisition(self, *, sample_rate=None, **values):
        self.frequency, self.polls = sample_rate or self.frequency, 0

    def read_status(self, *, read_data):
        self.polls += 1
        return Status.DONE if self.polls > 2 else Status.RUNNING


WANTED = GeneratorSettings(carrier_hz=28_200, peak_v=1.1)


def opened(module, wanted=WANTED):
    now = [0.0]

    def sleep(seconds):
        now[0] += seconds

    return AnalogDiscovery(wanted, module=module, sleep=sleep, clock=lambda: now[0])


def envelope(*, seconds=0.2, output="envelope"):
    x = Signal(np.random.default_rng(0).standard_normal(int(2000 * seconds)), 2000, "m/s^2")
    return modulated(x, Settings(output=output, q=100, pre_emphasis=True), rate=16_000)[0]


def test_what_comes_out_is_the_envelope_and_ends_in_silence():
    module, sent = SimulatedDwf(), envelope()
    with opened(module) as device:
        channel = module.channels[0]
        heard = []
        channel.configure = lambda start=False: (
            heard.append(channel.nodes[0].amplitude) or setattr(channel, "running", start)
        )
        device.play(sent)
        played = np.array(channel.played)
        channel.setup(amplitude=heard[0])
        volts = channel.output(played)
    np.testing.assert_allclose(volts[800:-16_384], sent.samples[0], atol=1e-6)
    assert not volts[:800].any()
    assert not volts[-16_384:].any()
    assert device.facts()["sent_samples"] == len(sent) + 16_384
    assert (channel.running, module.closed) == (False, True)


def test_it_is_silent_before_and_after():
    module = SimulatedDwf()
    with opened(module) as device:
        channel = module.channels[0]
        assert channel.nodes[0].amplitude == 0
        assert not channel.output([0.0]).any()
        device.play(envelope())
        assert channel.nodes[0].amplitude == 0


@settings(max_examples=60)
@given(
    st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=30), st.floats(0.01, 5.0)
)
def test_no_data_gives_more_than_the_peak(volts, peak):
    data = am_data(np.array(volts), peak)
    out = peak / 2 * (1 + data)
    assert np.isfinite(data).all()
    assert 0 <= out.min() <= out.max() <= peak * (1 + 1e-12)


def test_a_loop_stops_by_itself():
    module = SimulatedDwf()
    with opened(module) as device:
        device.loop(envelope(), 3.0)
        assert module.channels[0].run_length == 3.0
        assert module.channels[0].nodes[2].frequency == pytest.approx(5)
        long = Signal(np.ones(20_000), 16_000, "V")
        with pytest.raises(
            ParameterError, match=r"does not fit its buffer of 16384: lower the rate to 13107 Hz"
        ):
            device.loop(long, 1.0)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_a_loop_is_never_for_ever(seconds):
    module = SimulatedDwf()
    with opened(module) as device:
        with pytest.raises(ParameterError, match="must be > 0 s"):
            device.loop(envelope(), seconds)
        assert not module.channels[0].running
        assert module.channels[0].nodes[0].amplitude == 0


def test_a_killed_program_leaves_a_device_that_stops_soon_after():
    module = SimulatedDwf()
    with opened(module) as device:
        device.play(envelope(seconds=0.4))
        # Buffer and margin beyond the drive.
        assert 0.4 < module.channels[0].run_length < 0.4 + 16_384 / 16_000 + 1.2


def test_a_stream_longer_than_it_said_is_stopped():
    def endless():
        while True:
            yield np.full(160, 0.5)

    module = SimulatedDwf()
    with opened(module) as device:
        with pytest.raises(DeviceError, match="reached its time limit"):
            device.play(endless(), rate=16_000, longest_s=2.0)
        assert module.channels[0].nodes[0].amplitude == 0


def test_a_device_that_went_away_is_one_line_and_silence():
    module = SimulatedDwf()
    with opened(module) as device:
        module.gone = True
        with pytest.raises(DeviceError, match="digilent:first: device not found"):
            device.play(envelope())
        assert module.channels[0].nodes[0].amplitude == 0
    assert module.closed


def test_a_device_that_takes_nothing_is_not_waited_for_for_ever():
    module = SimulatedDwf()
    module.channels[0].free = 0
    with opened(module) as device, pytest.raises(DeviceError, match="accepted no samples for 2 s"):
        device.play(envelope())


def test_an_error_in_the_stream_silences_it():
    def broken():
        yield np.full(100, 0.5)
        raise ValueError("the model fell over")

    module = SimulatedDwf()
    with opened(module) as device:
        with pytest.raises(DeviceError, match="the model fell over"):
            device.play(broken(), rate=16_000)
        assert module.channels[0].nodes[0].amplitude == 0


def test_losses_are_counted():
    module = SimulatedDwf()
    module.channels[0].loses = 3
    with opened(module) as device:
        device.play(envelope())
    assert device.lost > 0


def test_what_a_device_lacks_is_said():
    mute = SimulatedDwf(functions=(Function.SINE, Function.CUSTOM))
    with opened(mute) as device, pytest.raises(DeviceError, match="does not stream"):
        device.play(envelope())
    with (
        pytest.raises(DeviceError, match="has no generator 2"),
        opened(SimulatedDwf(channels=1), GeneratorSettings(carrier_hz=28_200, peak_v=1, channel=2)),
    ):
        pass
    with (
        pytest.raises(DeviceError, match="No devices match"),
        opened(SimulatedDwf(), GeneratorSettings(carrier_hz=28_200, peak_v=1, serial="missing")),
    ):
        pass
    with pytest.raises(DeviceError, match="is not open"):
        opened(SimulatedDwf()).play(envelope())


def test_a_carrier_is_retuned():
    module = SimulatedDwf()
    with opened(module) as device:
        device.retune(28_150.5)
        assert module.channels[0].nodes[0].frequency == 28_150.5
        assert device.facts()["carrier_hz"] == 28_150.5


def test_settings_say_what_the_generator_gives():
    assert generator(Settings(limit_is="peak")).peak_v == pytest.approx(2.2)
    behind = ElectrovibrationSettings(newton_per_v2=2e-5, mu_0=0.3, v_max=140, amplifier_gain=50)
    assert generator(behind).peak_v == pytest.approx(2.8)
    with pytest.raises(ParameterError, match=r"supplies at most 5 V, but the settings allow 140 V"):
        generator(behind.model_copy(update={"amplifier_gain": 1.0}))


def test_only_envelopes_are_sent():
    with opened(SimulatedDwf()) as device:
        with pytest.raises(UnitError, match="in V"):
            device.play(Signal(np.ones(10), 16_000, "1"))
        with pytest.raises(ParameterError, match="output = 'envelope'"):
            device.play(Signal(np.array([1.0, -1.0]), 16_000, "V"))


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "dwfpy", None)
    with pytest.raises(MissingExtraError, match=r"tactogram\[dwf\]"):
        AnalogDiscovery(WANTED).__enter__()


def test_without_the_driver_its_name_is_said():
    pytest.importorskip("dwfpy")
    with pytest.raises(DeviceError, match="WaveForms"):
        AnalogDiscovery(WANTED).__enter__()


def test_a_held_carrier_has_the_amplitude_asked_for_and_stops_by_itself():
    module = SimulatedDwf()
    with opened(module) as device:
        channel = module.channels[0]
        device.hold(0.25, longest_s=30.0)
        assert channel.output(0.0) == pytest.approx(0.25)
        assert (channel.running, channel.run_length) == (True, 30.0)
        device.retune(28_300.0)
        assert channel.nodes[0].frequency == 28_300.0
        assert channel.output(0.0) == pytest.approx(0.25)
        with pytest.raises(ParameterError, match="0 to 1.1 V, got 1.2"):
            device.hold(1.2, longest_s=1.0)
        with pytest.raises(ParameterError, match="longest_s must be > 0 s"):
            device.hold(0.1, longest_s=0.0)
    assert channel.nodes[0].amplitude == 0
    assert not channel.running


def test_its_own_inputs_measure_what_the_generator_sends():
    """Hatori & Takemura 2023, Sec. III-C: the current "was measured by the FPGA using a current probe"."""
    module = SimulatedDwf()
    module.analog_input = SimulatedScope(module.channels[0])
    with opened(module) as device:
        device.hold(0.5, longest_s=30.0)
        recorder = DigilentRecorder(
            *device.opened_device, ScopeSettings(), name=device.name, sleep=lambda s: None, clock=lambda: 0.0
        )
        measure = MeasuredAdmittance(device, recorder, ProbeSettings(amps_per_volt=0.1, volts_per_volt=10))
        assert measure(28_210.0) == pytest.approx(0.02 * 0.1 / 10, rel=1e-6)
        assert recorder.full_scale == (25.0, 2.5)
        assert len(recorder.take(1.0, after_s=0.0)[0]) == 8192
        now = iter([0.0, 1.0, 9.0, 10.0])
        slow = DigilentRecorder(
            *device.opened_device, ScopeSettings(), name="d", sleep=lambda s: None, clock=lambda: next(now)
        )
        module.analog_input.read_status = lambda read_data: Status.RUNNING
        with pytest.raises(DeviceError, match="inputs delivered nothing"):
            slow.take(0.01, after_s=0.0)
        with pytest.raises(DeviceError, match="no input 3"):
            DigilentRecorder(*device.opened_device, ScopeSettings(current=3), name="d")
