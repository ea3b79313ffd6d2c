"""The chapters of a report: functions, each with a template named for its chapter; `page/chapters.py` gives their order."""
