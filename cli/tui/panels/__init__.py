"""The panels of the main screen: choices, rows, and the current orbit with its drawing and facts."""
