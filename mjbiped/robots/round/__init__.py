"""Bipeds with round feet: circular arcs, rigid on the legs, on which the stance leg rolls."""
