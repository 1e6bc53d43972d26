"""Cai et al.: a GAN into whose generator a classifier's features are fused; a baseline of visual_tactile_gan."""

from tactogram.models.residue_fusion_gan.config import Config as Config
from tactogram.models.residue_fusion_gan.learner import build as build
