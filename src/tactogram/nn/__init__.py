"""Parts of networks and their training that several models share."""

from tactogram.nn.adversarial_networks import gradient_penalty as gradient_penalty
from tactogram.nn.initial_weights import (
    MovingAverage as MovingAverage,
    glorot_linear as glorot_linear,
    strided_conv as strided_conv,
    strided_conv_transpose as strided_conv_transpose,
)
from tactogram.nn.wave_discriminator import (
    PhaseShuffle as PhaseShuffle,
    WaveDiscriminator as WaveDiscriminator,
)
from tactogram.nn.weight_files import (
    ALEXNET as ALEXNET,
    DENSENET201 as DENSENET201,
    INCEPTION as INCEPTION,
    VGG19 as VGG19,
    weight_file as weight_file,
)
