"""What a study comes to: requirements, alerts and the verdict."""
