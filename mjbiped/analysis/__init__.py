"""Analysis of records: engines compared, stability, survival."""
