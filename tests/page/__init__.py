"""The rider's page in a real Chromium, against a chair that really drives."""
