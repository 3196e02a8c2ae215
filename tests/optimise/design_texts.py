"""The device whose inputs the tests vary."""

DEVICE = """\
schema_version: 1
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 0.0041
  restitution: 0.5
  length_m: 0.7
  membrane: {thickness_m: 1.0e-3, relative_permittivity: 4.7, breakdown_field_v_m: 1.0e+8}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""
