"""From measured impacts to a device: its unknown inputs with their uncertainty, or why they are not known."""
