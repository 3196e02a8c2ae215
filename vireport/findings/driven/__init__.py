"""A recorded motion of the shaker driven through the device: what it does, beside the periodic motion predicted."""
