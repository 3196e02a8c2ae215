"""Maps over two or more parameters, of any size."""
