"""One run of one hammer: stepping, coupling, derivatives, blows, waves."""
