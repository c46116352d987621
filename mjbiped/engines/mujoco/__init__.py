"""The MuJoCo engine: rigid bodies and contacts."""
