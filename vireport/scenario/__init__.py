"""From a YAML file to a validated, frozen scenario or map, or to every mistake in it."""
