"""The engine `derived`: the quick-return's equations a second time, derived by the computer from a description."""
