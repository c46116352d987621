"""The tables, figures and claims of the reproduction's page."""
