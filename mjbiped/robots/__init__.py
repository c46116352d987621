"""The robots: masses, lengths, equations of motion."""
