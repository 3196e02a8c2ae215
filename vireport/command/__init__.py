"""What every command is made of: its options, the formats it writes, the files it reads, and how it delivers."""
