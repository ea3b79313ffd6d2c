"""The facts of each chapter: numbers, tables and plots, without text."""
