"""What all tests share."""

import os

# Plots are drawn without a display.
os.environ.setdefault("MPLBACKEND", "Agg")
