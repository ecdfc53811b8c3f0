"""Writes crates/samplers/data/lebedev.csv, the Lebedev rules of degree 3 to 131.

The source is scipy.integrate.lebedev_rule (scipy >= 1.15), which has the rules of Lebedev and
Laikov 1999. A rule is invariant under the octahedral group, so each orbit of nodes is one line:

    degree,a,b,c,w    a >= b >= c >= 0 the node of the orbit with sorted coordinates, w its weight

with weights that sum to 4 pi over all nodes. Usage: python benches/lebedev_rules.py > FILE
"""

import numpy as np
from scipy.integrate import lebedev_rule

DEGREES = [*range(3, 32, 2), *range(35, 132, 6)]

print("degree,a,b,c,w")
for degree in DEGREES:
    nodes, weights = lebedev_rule(degree)
    orbits = {}
    for node, weight in zip(nodes.T, weights):
        key = tuple(sorted(np.abs(node), reverse=True))
        orbits.setdefault(tuple(np.round(key, 9)), []).append((key, weight))
    for _, members in sorted(orbits.items(), reverse=True):
        node = np.median([key for key, _ in members], axis=0)
        # Coordinates that are equal or 0 by symmetry are so exactly.
        node[np.abs(node) < 1e-12] = 0.0
        if node[0] - node[1] < 1e-12:
            node[:2] = np.median([key[:2] for key, _ in members])
        if node[1] - node[2] < 1e-12:
            node[1:] = np.median([key[1:] for key, _ in members])
        a, b, c = (float(x) for x in node / np.linalg.norm(node))
        distinct = 6 // {1: 6, 2: 2, 3: 1}[len(set(node))]
        signs = 2 ** int(np.count_nonzero(node))
        assert len(members) == distinct * signs, (degree, node)
        print(f"{degree},{a!r},{b!r},{c!r},{float(np.median([w for _, w in members]))!r}")
