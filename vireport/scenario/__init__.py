"""From a YAML file to a validated, frozen scenario, or to every mistake in it."""

from vireport.scenario.loading import load as load
from vireport.scenario.loading import loads as loads
