"""What the device does when it is switched on: its outcome from rest, where that changes, and how fast it recovers."""
