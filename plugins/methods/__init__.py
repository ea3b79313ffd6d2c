"""Which method excels: rival methods, their errors and costs, hard scenes, and the map of classes of machines."""
