"""What the plugin adds to the page of a report: chapters on methods."""

from quickreturn.plugins.methods.chapters.classes import classes
from quickreturn.plugins.methods.chapters.methods import fastest_figure, methods
from quickreturn.reports.page.part import Part

PAGE = Part(chapters={methods: 50, classes: 51}, templates=("quickreturn.plugins.methods",), figure=fastest_figure)
