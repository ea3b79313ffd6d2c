"""Chapters on methods, a module and a template for each."""
