"""An O-ring in its groove, squeezed, then pressed by a fluid: forces, a picture, a curve.

Pictures need `pip install "signorini[plot]"` (or pyvista and matplotlib).
"""

import sys

import signorini as s

result = s.solve(s.example("o-ring"), progress=print).check()
print("closing force, N:", -result.obstacles["lid"].force[1])
print("on the wall, N:", -result.obstacles["wall"].force[0])
if len(sys.argv) > 1:
    result.plot("contact_pressure", file=f"{sys.argv[1]}/o-ring.png")
    result.plot_force(file=f"{sys.argv[1]}/o-ring-force.svg")
