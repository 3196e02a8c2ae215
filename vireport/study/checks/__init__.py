"""What the answers are held against: simulation, ball arithmetic, 40 digits, the paper's numbers, and other methods."""
