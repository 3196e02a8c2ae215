"""The catalogue of extreme cases: each answered within its bound, or refused with the reason."""
