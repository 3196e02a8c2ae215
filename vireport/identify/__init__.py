"""From measured impacts or raw signals to a device: the command, its files, its page and figures."""
