"""The biped with knees in MuJoCo."""
