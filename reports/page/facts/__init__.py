"""What each chapter tells: numbers, tables and plots, without words."""
