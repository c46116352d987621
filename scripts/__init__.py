"""Programs on mjbiped's public interface.

Each is run from the repository's root, by its dotted name: `python -m scripts.studies.gallery --help`.
"""
