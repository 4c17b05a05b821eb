"""Many runs of the airside program, on one machine or on a Ray cluster. No physics and no learning is in here."""
