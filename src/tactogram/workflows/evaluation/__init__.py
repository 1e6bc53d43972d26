"""Evaluation of classifiers, generators and predictors."""
