"""Two areas side by side: which is generated, and how real is each."""

from tactogram_study.designs.two_area.design import TwoArea as TwoArea
