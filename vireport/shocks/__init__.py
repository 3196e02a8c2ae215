"""What a stable motion withstands: the least shock that leads out of it, which starts come to it, random kicks."""
