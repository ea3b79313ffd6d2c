"""The chapters of a report: each is a module and a template of the same name; `page/chapters.py` gives their order."""
