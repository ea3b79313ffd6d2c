"""What the plugin adds to the page of a report: the resonance curves of the user's own machines."""

from quickreturn.plugins.studies.around import nearness, work
from quickreturn.plugins.studies.chapters.resonance import resonance
from quickreturn.reports.page.part import Part

PAGE = Part(chapters={resonance: 13}, templates=("quickreturn.plugins.studies",), work=work, nearness=nearness)
