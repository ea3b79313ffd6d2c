"""Chapters on studies, a module and a template for each."""
