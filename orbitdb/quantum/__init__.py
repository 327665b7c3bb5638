"""The quantum stadium: its levels, and what the orbits say of them."""
