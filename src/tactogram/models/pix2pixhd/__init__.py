"""Wang et al.: pix2pix at high resolution; a baseline of visual_tactile_gan."""

from tactogram.models.pix2pixhd.config import Config as Config
from tactogram.models.pix2pixhd.learner import build as build
