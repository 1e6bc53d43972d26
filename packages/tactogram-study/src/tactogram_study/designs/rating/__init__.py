"""Ratings: words on scales of steps."""

from tactogram_study.designs.rating.design import WordRating as WordRating
