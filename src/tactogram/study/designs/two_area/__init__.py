"""Two areas side by side: which is generated, and how real is each."""

from tactogram.study.designs.two_area.design import TwoArea as TwoArea
