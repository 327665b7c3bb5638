"""The quantum stadium: its levels, and what the orbits predict about them."""
