"""Parts of networks and their training that several models share."""

from tactogram.nn.adversarial_loss import gradient_penalty as gradient_penalty
from tactogram.nn.moving_average import MovingAverage as MovingAverage
from tactogram.nn.phase_shuffle import PhaseShuffle as PhaseShuffle
from tactogram.nn.strided_convolution import (
    glorot_linear as glorot_linear,
    strided_conv as strided_conv,
    strided_conv_transpose as strided_conv_transpose,
)
from tactogram.nn.wave_discriminator import WaveDiscriminator as WaveDiscriminator
