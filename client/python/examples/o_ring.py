"""An O-ring between two plates: the force, a picture, a curve.

Pictures need `pip install "signorini[plot]"` (or pyvista and matplotlib).
"""

import sys

import signorini as s

result = s.solve(s.example("o-ring"), progress=print).check()
print("closing force, N:", -result.obstacles["top"].force[1])
if len(sys.argv) > 1:
    result.plot("contact_pressure", file=f"{sys.argv[1]}/o-ring.png")
    result.plot_force(file=f"{sys.argv[1]}/o-ring-force.svg")
