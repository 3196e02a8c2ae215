"""Critical points proved in ball arithmetic, where `--certify` asks for it."""
