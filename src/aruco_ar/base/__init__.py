"""Basics that all other folders use: array types, errors, files, versions."""
