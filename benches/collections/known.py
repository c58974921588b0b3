"""Differences that were looked into, each with its reason."""

# Words in a file's path, and why Rhytid and the reference differ there.
KNOWN = {}


def reason(path):
    return next((why for words, why in KNOWN.items() if words in str(path)), None)
