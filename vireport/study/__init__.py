"""What is done for a scenario: its plan, its results, and the files for machines."""
